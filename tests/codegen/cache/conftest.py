"""A cache in which one entry has been made."""

import subprocess
import sys

import pytest

from entries import KEY, OTHER, Maker, obtain
from hillobs.codegen import cache


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache in which one entry has been made."""
    monkeypatch.setenv("HILLOBS_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(cache, "_private", {})
    obtain(Maker())
    return tmp_path / "cache"


@pytest.fixture
def manifest(folder):
    return folder / f"{KEY}.json"


@pytest.fixture
def library(folder):
    return next(folder.glob(f"{KEY}-*.so"))


@pytest.fixture
def source(folder):
    return folder / f"{KEY}.cpp"


HOLD = (
    "import fcntl; file = open(sys.argv[1], 'a'); fcntl.flock(file, fcntl.LOCK_EX); print('held', flush=True); input()"
)


@pytest.fixture
def holder(folder):
    """Another process that holds the lock of OTHER."""
    command = [sys.executable, "-c", "import sys; " + HOLD, str(folder / f"{OTHER}.lock")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        yield process
        process.kill()
