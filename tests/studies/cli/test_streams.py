"""Full, closed and abandoned streams: no traceback, and the exit code that the run deserves."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from forks import Forks


def test_a_closed_pipe_is_silent() -> None:
    done = subprocess.run(
        ["bash", "-c", f"{sys.executable} -m hillobs list | head -1"], capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.stderr) == ("scenarios:\n", "")


QUICK = ["list", "show paper-clean", "info"]
SIMULATE = ["simulate", "paper-clean", "--no-figures", "--set", "duration=0.1"]


@pytest.mark.parametrize("words", QUICK)
def test_a_full_stdout_is_a_sentence(words: str) -> None:
    if not os.path.exists("/dev/full"):
        pytest.skip("no /dev/full here")
    line = f"{sys.executable} -m hillobs {words} >/dev/full"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert done.returncode in (1, 2)
    assert "Traceback" not in done.stderr
    assert "No space left" in done.stderr


@pytest.mark.parametrize(
    ("words", "stream"),
    [(QUICK[0], ">&-"), (QUICK[0], "2>&-"), (QUICK[0], ">&- 2>&-"), (" ".join([*SIMULATE, "--out OUT"]), ">&- 2>&-")],
)
def test_a_closed_stream_does_no_harm(words: str, stream: str, tmp_path: Path) -> None:
    line = f"{sys.executable} -m hillobs {words} {stream}".replace("OUT", str(tmp_path))
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("words", [*QUICK, "--help", "--version"])
def test_a_reader_that_leaves_is_no_failure(words: str) -> None:
    """Exit code 0 or that of SIGPIPE: 1 would say that numbers failed."""
    line = f"{sys.executable} -m hillobs {words} | true; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.returncode in (0, 141)


# as that of a sweep: a full stream is a mistake, a reader that leaves or a closed stream is none
STREAMS = [
    ({"stdout": "/dev/full"}, 2, "hillobs: standard output: No space left on device\n"),
    ({"stdout": "broken"}, 141, ""),
    ({"stdout": "closed"}, 0, ""),
    ({"stderr": "closed"}, 0, ""),
]


@pytest.mark.parametrize(("streams", "code", "words"), STREAMS, ids=["full", "left", "no stdout", "no stderr"])
def test_a_simulation_that_nobody_hears_is_written(
    streams: dict[str, str], code: int, words: str, forks: Forks, tmp_path: Path
) -> None:
    done = forks.run(tmp_path, *SIMULATE, "--out", ".", **streams)
    assert (done.code, done.err) == (code, words)
    assert len(list(tmp_path.glob("*.nc"))) == 1


@pytest.mark.parametrize("stream", ["2>/dev/full", "2>&1 | true; exit ${PIPESTATUS[0]}"])
@pytest.mark.parametrize("words", ["simulate nothing", "--no-such-option"])
def test_a_mistake_that_nobody_hears_has_its_exit_code(words: str, stream: str) -> None:
    done = subprocess.run(["bash", "-c", f"{sys.executable} -m hillobs {words} {stream}"], check=False)
    assert done.returncode == 2
