"""Full, closed and abandoned streams: no traceback, and the exit code that the run deserves."""

import os
import subprocess
import sys
from pathlib import Path

import pytest


def test_a_closed_pipe_is_silent() -> None:
    done = subprocess.run(
        ["bash", "-c", f"{sys.executable} -m hillobs list | head -1"], capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.stderr) == ("scenarios:\n", "")


CLOSED = ["list", "show paper-clean", "info", "simulate paper-clean --no-figures --set duration=0.1 --out OUT"]


@pytest.mark.parametrize("words", CLOSED)
def test_a_full_stdout_is_a_sentence(words: str, tmp_path: Path) -> None:
    if not os.path.exists("/dev/full"):
        pytest.skip("no /dev/full here")
    line = f"{sys.executable} -m hillobs {words} >/dev/full".replace("OUT", str(tmp_path))
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert done.returncode in (1, 2)
    assert "Traceback" not in done.stderr
    assert "No space left" in done.stderr


@pytest.mark.parametrize("stream", [">&-", "2>&-", ">&- 2>&-"])
@pytest.mark.parametrize("words", CLOSED[:1] + CLOSED[-1:], ids=["list", "simulate"])
def test_a_closed_stream_does_no_harm(words: str, stream: str, tmp_path: Path) -> None:
    line = f"{sys.executable} -m hillobs {words} {stream}".replace("OUT", str(tmp_path))
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("words", [*CLOSED, "--help", "--version"])
def test_a_reader_that_leaves_is_no_failure(words: str, tmp_path: Path) -> None:
    """Exit code 0 or that of SIGPIPE: 1 would say that numbers failed."""
    line = f"{sys.executable} -m hillobs {words} | true; exit ${{PIPESTATUS[0]}}".replace("OUT", str(tmp_path))
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.returncode in (0, 141)


@pytest.mark.parametrize("stream", ["2>/dev/full", "2>&1 | true; exit ${PIPESTATUS[0]}"])
@pytest.mark.parametrize("words", ["simulate nothing", "--no-such-option"])
def test_a_mistake_that_nobody_hears_has_its_exit_code(words: str, stream: str) -> None:
    done = subprocess.run(["bash", "-c", f"{sys.executable} -m hillobs {words} {stream}"], check=False)
    assert done.returncode == 2
