"""A process that has everything loaded: each case of a fault test runs in a fork of it, within milliseconds.

Audit hooks and limits cannot be taken back; a fork takes them with it.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import gc
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

# runs in one part of the sweeps here
PART = 4
# duration, observers and parts of them: the first part, one between, the last
TINY = ["--set", "duration=0.05", "--set", "score.start=0.01", "--observer", "high_gain", "--quantity", "x2"]
COMMAND = ["sweep", "paper-noisy", *TINY, "--over", "high_gain.eps_h=0.05,0.1,0.2", "--seeds", "4"]
PARTS = 3

# calls that Python reports, and what we report of those that it does not
_COUNTED = {
    *("open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.chmod", "os.listdir", "os.scandir", "os.truncate"),
    *("fcntl.flock", "fsync", "pwrite", "pread"),
}


@dataclass(frozen=True)
class Result:
    """What a command did: exit code or minus the signal, what it said, its calls in order, the parts it computed."""

    code: int
    out: str
    err: str
    calls: list[str]
    computed: list[int]


class Forks:
    """Runs commands in forks of one process; a context."""

    def __enter__(self) -> Forks:
        pipe = subprocess.PIPE
        self._process = subprocess.Popen([sys.executable, __file__], stdin=pipe, stdout=pipe, text=True)
        return self

    def __exit__(self, *_: object) -> None:
        self._process.communicate(timeout=60)

    def run(self, folder: Path, *arguments: str, **case: object) -> Result:
        """`hillobs ARGUMENTS` in a folder.

        fault: an errno or a signal by name, or REMOVED for the parts, at the call `at` (counted from 1), or `ever`
        after, or `twice` at once. near: at the first call with that in its words instead. limits: resource → number.
        stdout, stderr: a file, `closed` or `broken`. gone: the folder is removed first.
        deaf: signals that are ignored from the start. uid: as that user, who has a cache of libraries at `cache`.
        """
        asked = {"arguments": arguments, "folder": str(folder), **case}
        assert self._process.stdin
        assert self._process.stdout
        print(json.dumps(asked), file=self._process.stdin, flush=True)
        answer = json.loads(self._process.stdout.readline())
        # which test is the first to compile a library is chance
        complaints = [line for line in answer["err"].splitlines(keepends=True) if "hillobs: compiling " not in line]
        return Result(**{**answer, "err": "".join(complaints)})

    def memory(self) -> int:
        """Bytes of address space that the process has."""
        return int(Path(f"/proc/{self._process.pid}/statm").read_text().split()[0]) * os.sysconf("SC_PAGESIZE")


def _serve() -> None:
    """Answer cases on standard input until it ends."""
    os.environ["COLUMNS"] = "120"
    from hillobs.studies.cli import main as cli
    from hillobs.studies.figures.sweep import figures as sweep_figures  # noqa: F401  what is imported here, no fork imports again
    from hillobs.studies.sweep import plan

    plan.PART = PART
    # where files may not grow, Python leaves its own cut short in the checkout, and nothing starts any more
    sys.dont_write_bytecode = True
    with tempfile.TemporaryDirectory() as folder, open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        cli.commands([*COMMAND, "--out", f"{folder}/warm.nc"], standalone_mode=False)
    gc.freeze()  # a collection in a fork would copy all memory
    for line in sys.stdin:
        case, pipes = json.loads(line), {name: os.pipe() for name in ("report", "stdout", "stderr")}
        child = os.fork()
        if child == 0:
            os._exit(_command(case, {name: end for name, (_, end) in pipes.items()}))
        said = {}
        for name, (reader, writer) in pipes.items():
            os.close(writer)
            with open(reader, errors="replace") as file:
                said[name] = file.read()
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        told = [words.split(maxsplit=1) for words in said["report"].splitlines()]
        calls = [words for kind, words in told if kind == "call"]
        computed = [int(words) for kind, words in told if kind == "part"]
        answer = {"code": code, "out": said["stdout"], "err": said["stderr"], "calls": calls, "computed": computed}
        print(json.dumps(answer), flush=True)


def _command(case: dict, streams: dict[str, int]) -> int:
    """Run the command of a case to the end of its process; its exit code."""
    from hillobs import __main__ as start

    start._LEAST = 1  # all is loaded: memory may end later, and less of it is enough

    def command() -> None:
        _become(case, streams)
        start.main()

    return exit_code(command)


def exit_code(program: Callable[[], None]) -> int:
    """Run a program to the end of its process, as Python would; its exit code, for `os._exit`."""
    code = 0
    try:
        program()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        with contextlib.suppress(OSError):  # nobody may hear it
            traceback.print_exc()
        code = 1
    # what Python does at its end, but for the slow destruction of all objects
    threading._shutdown()
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError):
            if stream:
                stream.flush()
    return code


def _become(case: dict, streams: dict[str, int]) -> None:
    """Turn this fork into the command of a case."""
    sys.argv = ["hillobs", *case["arguments"]]
    signal.alarm(300)  # nothing here may take so long
    for name in case.get("deaf", ()):
        signal.signal(getattr(signal, name), signal.SIG_IGN)
    os.chdir(case["folder"])
    if case.get("gone"):
        os.rmdir(case["folder"])
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for number, name in enumerate(("stdout", "stderr"), 1):
        redirect(number, name, case.get(name, ""), streams[name])
    _tell(streams["report"], case)
    if "uid" in case:
        os.environ["HILLOBS_CACHE"] = case["cache"]
        become_user(case["uid"])
    for name, number in case.get("limits", {}).items():
        kind = getattr(resource, name)
        resource.setrlimit(kind, (number, resource.getrlimit(kind)[1]))


def become_user(uid: int) -> None:
    """Give up root for good, to be a user without a name."""
    os.setgroups([])
    os.setgid(uid)
    os.setuid(uid)


def redirect(number: int, name: str, where: str, otherwise: int) -> None:
    """Let stdout or stderr of this process go to a file, be `closed` or `broken` (its reader is gone), or otherwise."""
    handle = otherwise
    if where == "broken":
        reader, handle = os.pipe()
        os.close(reader)
    elif where and where != "closed":
        handle = os.open(where, os.O_WRONLY)
    os.dup2(handle, number)
    setattr(sys, name, None if where == "closed" else open(number, "w", closefd=False, encoding="utf-8"))  # noqa: SIM115
    if where == "closed":
        os.close(number)


def _tell(report: int, case: dict) -> None:
    """Count the calls that have to do with the folder of the case, and strike at one; tell of them and of parts."""
    from hillobs.studies.files.quote import escaped
    from hillobs.studies.sweep import computing as parts

    folder, at, near = case["folder"], case.get("at", 0), case.get("near", "")
    compute_part, count, inside = parts.compute_part, 0, threading.local()

    def tell(*words: object) -> None:
        with contextlib.suppress(OSError):
            os.write(report, (escaped(" ".join(map(str, words))) + "\n").encode())

    def computing(wanted, compiled, part, *rest):
        tell("part", part)
        sys.audit("kernel", folder)
        return compute_part(wanted, compiled, part, *rest)

    parts.compute_part = computing
    for name in ("fsync", "pwrite", "pread"):
        setattr(os, name, _audited(name, getattr(os, name)))

    def hook(event: str, arguments: tuple) -> None:
        nonlocal at, count
        place = arguments[0] if arguments else ""
        if getattr(inside, "hook", False) or not (event in _COUNTED or event == near):
            return
        if isinstance(place, str | os.PathLike) and os.path.isabs(place) and not os.fspath(place).startswith(folder):
            return
        inside.hook = True
        try:
            count += 1
            words = f"{event} {place}".replace(folder, "")
            tell("call", words)
            if near and near in words and not at:
                at = count
            if count == at or (case.get("ever") and 0 < at <= count):
                for _ in range(1 + bool(case.get("twice"))):
                    _strike(str(case["fault"]), folder)
        finally:
            inside.hook = False

    sys.addaudithook(hook)


def _audited(name, function):
    def audited(*arguments):
        sys.audit(name, *arguments)
        return function(*arguments)

    return audited


def _strike(fault: str, folder: str) -> None:
    if fault == "REMOVED":
        shutil.rmtree(f"{folder}/x.nc.parts")
    elif fault.startswith("SIG"):
        os.kill(os.getpid(), getattr(signal, fault))
    else:
        code = getattr(errno, fault)
        raise OSError(code, os.strerror(code))


if __name__ == "__main__":
    _serve()
