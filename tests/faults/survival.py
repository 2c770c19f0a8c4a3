"""What must hold after every fault of a sweep: whole files only, one sentence, and the same result in the end."""

import hashlib
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

from forks import COMMAND, PARTS, Forks, Result

SWEEP = [*COMMAND, "--no-figures", "--workers", "1", "--out", "x.nc"]
ERRORS = {"ENOSPC": "No space left on device", "EIO": "Input/output error", "EACCES": "Permission denied"}


STOPPED = {
    "hillobs: stopped\n",
    "hillobs: stopped; what is done is kept in x.nc.parts, the same command goes on\n",
    "hillobs: stopped; the result is in x.nc, the same command draws it\n",
}


def is_whole(path: Path) -> bool:
    """Whether its seal is right, without the code under test."""
    raw = path.read_bytes()
    return raw[-40:] == b"hillobs " + hashlib.sha256(raw[:-40]).digest()


def kept(folder: Path) -> list[int]:
    """The parts in the folder; each is whole, as is the result if it is there."""
    files = sorted((folder / "x.nc.parts").glob("*.part"))
    assert all(is_whole(path) for path in [*files, *folder.glob("x.nc")] if path.is_file())
    return [int(path.stem) for path in files]


def assert_goes_on(forks: Forks, folder: Path, whole: bytes) -> Result:
    """The same command again: what was kept is not computed again, the result is the same to the last byte."""
    missing = [] if (folder / "x.nc").exists() else sorted(set(range(PARTS)) - set(kept(folder)))
    again = forks.run(folder, *SWEEP)
    assert (again.code, again.err) == (0, "")
    assert again.computed == missing
    assert (folder / "x.nc").read_bytes() == whole
    assert os.listdir(folder) == ["x.nc"]
    return again


def assert_survives(forks: Forks, folder: Path, whole: bytes, **case: object) -> Result:
    """A command with a fault, then without."""
    folder.mkdir()
    done = forks.run(folder, *SWEEP, **case)
    assert "Traceback" not in done.err
    assert len(done.err.splitlines()) <= 1
    assert_goes_on(forks, folder, whole)
    return done


def writes(calls: list[str]) -> list[list[int]]:
    """The calls, counted from 1, that write each part, and those that write the result and remove the parts."""
    starts = [i for i, call in enumerate(calls, 1) if re.match(r"open \.(\d{8}\.part|x\.nc)-", call)]
    end = 1 + max(i for i, call in enumerate(calls, 1) if call.startswith("os.rmdir"))
    return [list(range(first, last)) for first, last in zip(starts, [*starts[1:], end], strict=True)]


SLOW_COMPILER = """#!/bin/sh
case "$*" in *--version*) exec c++ "$@";; esac
echo $$ > {folder}/compiler
kill -{name} {whom}
exec sleep 100
"""


def assert_a_signal_ends_both(folder: Path, name: str) -> None:
    script = folder / "slow"
    script.write_text(SLOW_COMPILER.format(folder=folder, name=name, whom="$PPID"))
    script.chmod(0o755)
    environment = os.environ | {"CXX": str(script), "HILLOBS_CACHE": str(folder / "cache")}
    command = [sys.executable, "-m", "hillobs", *SWEEP]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=60)
    assert done.returncode == 128 + getattr(signal, f"SIG{name}")
    compiling, stopped = done.stderr.splitlines()
    assert compiling.startswith("hillobs: compiling ")
    assert stopped == "hillobs: stopped"
    assert not is_running(int((folder / "compiler").read_text()))
    assert not list((folder / "cache").glob("*.tmp"))


def is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    status = Path(f"/proc/{pid}/stat")
    return not status.exists() or status.read_text().rpartition(")")[2].split()[0] != "Z"
