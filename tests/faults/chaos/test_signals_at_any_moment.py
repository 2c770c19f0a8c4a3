"""Signals at random moments of every command, start-up and end included; run by `make chaos`, minutes long."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hillobs.studies import laboratory

pytestmark = pytest.mark.chaos

SHORT = ["--set", "duration=0.2", "--set", "score.start=0.1"]
RECORDINGS = Path(laboratory.__path__[0]) / "recordings"
COMMANDS = {
    "simulate": ["paper-noisy", *SHORT],
    "sweep": ["paper-noisy", *SHORT, "--over", "high_gain.eps_h=0.05,0.1", "--seeds", "8", "--out", "x.nc"],
    "estimate": [str(RECORDINGS / "dgf_smooth_noisy.csv.gz"), "--muscles", str(RECORDINGS / "dgf_smooth.toml")],
    "observability": ["--along", *SHORT],
    "curves": [],
    "errata": [],
    "show": ["challenge"],
    "list": [],
    "info": [],
}
MOMENTS = 10  # of each command
LIST = f".hillobs-{os.geteuid()}"  # which of a folder's files are ours: it stays
# told when the handlers are there: before that Python is at its own start
STARTED = """
from hillobs import __main__ as entry
command_line = entry._command_line

def told():
    print("started", flush=True)
    command_line()

entry._command_line = told
entry.main()
"""


@pytest.mark.parametrize("twice", [False, True], ids=["once", "twice"])
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
@pytest.mark.parametrize("command", COMMANDS)
def test_at_random_moments(command: str, name: str, twice: bool, tmp_path: Path, record_property) -> None:
    number, draw = getattr(signal, name), random.Random(f"{command} {name} {twice}")
    assert _end(_start(command, tmp_path))[0] == 0  # compiles, and keeps what the next start finds
    start = time.monotonic()
    assert _end(_start(command, tmp_path))[0] == 0
    seconds, ended = time.monotonic() - start, 0
    for _ in range(MOMENTS):
        process = _start(command, tmp_path)
        for _ in range(1 + twice):
            time.sleep(draw.uniform(0, seconds / (1 + twice)))
            process.send_signal(number)
        code, err = _end(process)
        assert code in (0, 128 + number), (code, err)
        assert [line for line in err.splitlines() if "hillobs: compiling " not in line][1:] == [], err
        assert "Traceback" not in err
        ended += code != 0
        left = {path.name for path in tmp_path.rglob(".*") if path.is_file() and "x.nc.parts" not in path.parts}
        assert left <= {LIST}
    assert ended
    record_property("faults", MOMENTS)


def _start(command: str, folder: Path) -> subprocess.Popen[str]:
    """The command, where its handlers have just been installed."""
    told = [sys.executable, "-c", STARTED, command, *COMMANDS[command]]
    pipe = subprocess.PIPE
    process = subprocess.Popen(told, cwd=folder, env=os.environ, stdout=pipe, stderr=pipe, text=True)
    assert process.stdout
    assert process.stdout.readline() == "started\n"
    return process


def _end(process: subprocess.Popen[str]) -> tuple[int, str]:
    _, err = process.communicate(timeout=300)
    return process.returncode, err
