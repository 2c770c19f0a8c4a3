"""Sweeps in processes of their own, killed at any time and failed by the system at each of its calls. Minutes long."""

import contextlib
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from forks import PART
from survival import SWEEP, is_whole, kept

pytestmark = pytest.mark.chaos

LONG = [
    *(sys.executable, "-m", "hillobs", "sweep", "paper-noisy", "--no-figures", "--quantity", "x2", "--out", "x.nc"),
    *("--over", "high_gain.eps_h=log:0.02:0.5:100", "--seeds", "100", "--set", "duration=10"),
]


@pytest.fixture(scope="module")
def long(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, float]:
    """The result of the long sweep, and how long it takes."""
    folder = tmp_path_factory.mktemp("long")
    for _ in range(2):  # the first one compiles
        shutil.rmtree(folder)
        folder.mkdir()
        start = time.monotonic()
        subprocess.run(LONG, cwd=folder, check=True, capture_output=True)
    return (folder / "x.nc").read_bytes(), time.monotonic() - start


@pytest.mark.parametrize("seed", range(4))
def test_fifty_kills_at_random_times(long, tmp_path: Path, record_property, seed: int) -> None:
    """Of one sweep after another; each goes on until it is done."""
    whole, seconds = long
    draw, kills = random.Random(seed), 0
    while kills < 50:
        process = subprocess.Popen(LONG, cwd=tmp_path, stderr=subprocess.PIPE, text=True, stdout=subprocess.DEVNULL)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(draw.uniform(0, 1.2 * seconds))
        process.kill()
        _, err = process.communicate()
        assert err == ""
        kept(tmp_path)
        if process.returncode == 0:
            assert (tmp_path / "x.nc").read_bytes() == whole
            assert os.listdir(tmp_path) == ["x.nc"]
            (tmp_path / "x.nc").unlink()
        else:
            assert process.returncode == -signal.SIGKILL
            kills += 1
    done = subprocess.run(LONG, cwd=tmp_path, check=True, capture_output=True, text=True)
    assert done.stderr == ""
    assert (tmp_path / "x.nc").read_bytes() == whole
    assert os.listdir(tmp_path) == ["x.nc"]
    record_property("faults", kills)


def test_eight_at_once_make_one_result(long, tmp_path: Path) -> None:
    """One computes; the others are refused with its name, or read what it has made."""
    pipe = subprocess.PIPE
    every = [subprocess.Popen(LONG, cwd=tmp_path, stdout=pipe, stderr=pipe, text=True) for _ in range(8)]
    said = [process.communicate(timeout=300) for process in every]
    codes = [process.returncode for process in every]
    assert set(codes) <= {0, 2}
    assert 0 in codes
    for code, (_, err) in zip(codes, said, strict=True):
        assert err == "" if code == 0 else "x.nc is being computed by process" in err
    assert (tmp_path / "x.nc").read_bytes() == long[0]
    assert os.listdir(tmp_path) == ["x.nc"]


@pytest.fixture(scope="module")
def strace() -> str:
    """The path of strace, if it may be used here."""
    path = shutil.which("strace")
    if path is None:
        pytest.skip("strace is not installed")
    probe = [path, "-o", "/dev/null", "-e", "inject=getppid:error=EIO", "true"]
    if subprocess.run(probe, capture_output=True).returncode:
        pytest.skip("strace cannot trace here")
    return path


ONE_PART = [sys.executable, "-m", "hillobs", *(word for word in SWEEP if word not in ("--workers", "1"))]


@pytest.mark.parametrize("action", ["KILL", "ENOSPC", "EIO"])
@pytest.mark.parametrize(
    "call", ["openat", "write", "pwrite64", "fsync", "flock", "ftruncate", "mkdirat", "renameat", "unlinkat"]
)
def test_each_call_of_the_system(tmp_path: Path, strace: str, record_property, call: str, action: str) -> None:
    """In the order in which the kernel sees them; those before the first that has to do with the sweep start Python."""
    assert PART < 512
    log, folder = tmp_path / "log", tmp_path / "first"
    folder.mkdir()
    traced = [strace, "-f", "-qq", "-y", "-o", str(log), "-e", f"trace={call}"]
    subprocess.run([*traced, *ONE_PART], cwd=folder, check=True, capture_output=True)
    whole = (folder / "x.nc").read_bytes()
    lines = [line for line in log.read_text(errors="replace").splitlines() if f" {call}(" in line]
    ours = [i for i, line in enumerate(lines, 1) if "x.nc" in line]
    for at in ours:
        here = tmp_path / str(at)
        here.mkdir()
        effect = "signal=KILL" if action == "KILL" else f"error={action}"
        fault = ["-e", f"inject={call}:{effect}:when={at}"]
        done = subprocess.run([*traced, *fault, *ONE_PART], cwd=here, capture_output=True, text=True, check=False)
        assert "Traceback" not in done.stderr
        assert done.returncode in (0, 1, 2, -signal.SIGKILL, 128 + signal.SIGKILL)
        assert all(is_whole(path) for path in [*here.glob("x.nc"), *here.glob("x.nc.parts/*.part")])
        subprocess.run(ONE_PART, cwd=here, check=True, capture_output=True)
        assert (here / "x.nc").read_bytes() == whole
        assert os.listdir(here) == ["x.nc"]
    record_property("faults", len(ours))
