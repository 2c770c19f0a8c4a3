"""The same in other surroundings: without asserts, in a German locale, without a compiler, with ASCII only."""

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from command_line import CHANGED, SHORT, in_a_process

Command = Callable[..., tuple[int, str, str]]


def test_it_is_the_same_without_asserts(command: Command, tmp_path: Path) -> None:
    """python -O: nothing a user can reach is guarded by an assert."""
    words = ["simulate", "--set", "plant.m=0", "--out", str(tmp_path)]
    done = in_a_process("-O", "-m", "hillobs", *words)
    assert (done.returncode, done.stderr) == (2, "hillobs: plant.m must be above 0, not 0\n")
    assert command(*words) == (2, "", done.stderr)


def test_a_german_locale_keeps_the_point(command: Command, tmp_path: Path) -> None:
    if not shutil.which("localedef"):
        pytest.skip("no localedef to make a German locale with")
    made = subprocess.run(
        ["localedef", "-i", "de_DE", "-f", "UTF-8", tmp_path / "de_DE.UTF-8"], capture_output=True, check=False
    )
    if not (tmp_path / "de_DE.UTF-8").is_dir():
        pytest.skip(f"localedef has no German locale: {made.stderr.decode()[:80]}")
    german = {"LOCPATH": str(tmp_path), "LC_ALL": "de_DE.UTF-8"}
    words = ["simulate", "paper-noisy", *SHORT, "--no-figures", "--out"]
    done = in_a_process("-m", "hillobs", *words, str(tmp_path / "de"), **german)
    assert done.returncode == 0, done.stderr
    assert command(*words, str(tmp_path / "c"))[0] == 0
    there, here = ((tmp_path / name / f"paper-noisy{CHANGED}.csv").read_text() for name in ("de", "c"))
    assert there == here
    done = in_a_process("-m", "hillobs", "simulate", "--set", "plant.m=1,5", **german)
    assert (done.returncode, done.stderr) == (2, "hillobs: plant.m must be a number, not '1,5'\n")


def test_without_a_compiler_it_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    environment = {"PATH": str(tmp_path / "empty"), "HILLOBS_CACHE": str(tmp_path / "cache"), "CXX": "", "CC": ""}
    done = in_a_process("-m", "hillobs", "simulate", *SHORT, "--no-figures", "--out", str(tmp_path), **environment)
    if "ziglang" in in_a_process("-m", "pip", "list").stdout:
        pytest.skip("the compiler wheel is installed")
    assert done.returncode == 2
    assert "apt install g++" in done.stderr
    assert "hillobs[compiler]" in done.stderr


def test_ascii_output_degrades() -> None:
    done = in_a_process("-m", "hillobs", "list", "observers", PYTHONIOENCODING="ascii")
    assert done.returncode == 0
    assert "high_gain" in done.stdout
