"""The process of a case, forked from this one or started afresh, followed to its end and beyond."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import json
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import matplotlib

from forks import exit_code, redirect
from hostile.calls import limit, run_program, strike_at_calls, teller
from hostile.case import Case
from hostile.sandbox import DESK, HOME, TEMPORARY

# seconds; nothing that is drawn takes a tenth of it
GUARD = 60.0
# seconds that what is killed may take to be gone
_GRACE = 5.0
_SUBREAPER = 36  # PR_SET_CHILD_SUBREAPER
# bytes; one case must not take the memory of all others
_MEMORY = 6_000_000_000
_LAUNCH = Path(__file__).with_name("launch.py")
# what a case inherits of the surroundings; the rest is the same for everybody
_KEPT = ("PATH", "HILLOBS_CACHE", "LD_LIBRARY_PATH")


@dataclass(frozen=True)
class Ending:
    """Exit code or minus the signal, what was written, the signals that came, and what is left running."""

    code: int
    out: str
    err: str
    came: tuple[str, ...]
    hung: bool
    orphans: int


def adopt_orphans() -> None:
    """Become the parent of what a case leaves running, so that it is found."""
    ctypes.CDLL(None, use_errno=True).prctl(_SUBREAPER, 1, 0, 0, 0)


def run(case: Case, box: Path, given: bytes) -> Ending:
    """Run the command of a case in its folder, with `given` on standard input."""
    pipes = {name: os.pipe() for name in ("report", "stdout", "stderr")}
    writers = {name: writer for name, (_, writer) in pipes.items()}
    source = _source(case, given)
    process = (_afresh if case.fresh else _forked)(case, box, source, writers)
    for end in (source, *writers.values()):
        os.close(end)
    said, hung = _listen({name: reader for name, (reader, _) in pipes.items()}, process)
    code = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    orphans = _end_orphans()
    return Ending(code, said["stdout"], said["stderr"], tuple(said["report"].split()), hung, orphans)


def _source(case: Case, given: bytes) -> int:
    """What standard input is read from."""
    if case.streams.get("stdin") == "unreadable":
        return os.open("/proc/self/mem", os.O_RDONLY)  # its first bytes are those of nobody
    source = os.memfd_create("stdin")
    os.write(source, given)
    os.lseek(source, 0, os.SEEK_SET)
    return source


def _surroundings(case: Case, box: Path) -> dict[str, str]:
    usual = {name: os.environ[name] for name in _KEPT if name in os.environ}
    usual |= {"HOME": str(box / HOME), "TMPDIR": str(box / TEMPORARY), "LC_ALL": "C.UTF-8", "OPENBLAS_NUM_THREADS": "1"}
    # where files may not grow, Python leaves its own cut short in the checkout, and nothing starts any more
    usual["PYTHONDONTWRITEBYTECODE"] = "1"
    # its list of fonts takes seconds to make
    usual["MPLCONFIGDIR"] = _fonts()
    changed = {name: value and value.replace("BOX", str(box)) for name, value in case.environment.items()}
    return {name: value for name, value in {**usual, **changed}.items() if value is not None}


@functools.cache
def _fonts() -> str:
    return matplotlib.get_cachedir()


def _forked(case: Case, box: Path, source: int, pipes: Mapping[str, int]) -> int:
    child = os.fork()
    if child == 0:
        os._exit(exit_code(lambda: _become(case, box, source, pipes)))
    return child


def _become(case: Case, box: Path, source: int, pipes: Mapping[str, int]) -> None:
    """Turn this fork into the command of a case."""
    from hillobs import __main__ as start

    start._LEAST = 1  # all is loaded: memory may end later, and less of it is enough
    sys.dont_write_bytecode = True  # as in the surroundings, which Python has read already
    os.setsid()
    _hear_signals()
    os.chdir(box / DESK)
    sys.argv = ["hillobs", *case.words]
    surroundings = _surroundings(case, box)
    os.environ.clear()
    os.environ.update(surroundings)
    _hear(case, source)
    for number, name in enumerate(("stdout", "stderr"), 1):
        redirect(number, name, _where(case, name), pipes[name])
        os.close(pipes[name])
    limit({"RLIMIT_AS": _MEMORY, **case.limits})
    strike_at_calls(case.signals, teller(pipes["report"]))
    if case.python:
        run_program(case.python)
    else:
        start.main()


def _hear(case: Case, source: int) -> None:
    """Let standard input of this process be another one."""
    os.dup2(source, 0)
    if case.streams.get("stdin") == "closed":
        sys.stdin = None
        os.close(0)
    else:
        sys.stdin = os.fdopen(0, closefd=False)


def _afresh(case: Case, box: Path, source: int, pipes: Mapping[str, int]) -> int:
    asked = json.dumps({name: getattr(case, name) for name in ("words", "python", "limits", "signals")})

    def prepare() -> None:
        _hear_signals()
        limit({"RLIMIT_AS": _MEMORY})
        for number, name in enumerate(("stdout", "stderr"), 1):
            redirect(number, name, _where(case, name), number)
        if case.streams.get("stdin") == "closed":
            os.close(0)

    started = subprocess.Popen(
        [sys.executable, str(_LAUNCH), str(pipes["report"]), asked],
        cwd=box / DESK,
        env=_surroundings(case, box),
        stdin=source,
        stdout=pipes["stdout"],
        stderr=pipes["stderr"],
        pass_fds=[pipes["report"]],
        start_new_session=True,
        preexec_fn=prepare,
    )
    started.returncode = 0  # waited for below, not by subprocess
    return started.pid


def _hear_signals() -> None:
    """A test that runs in the background has inherited deaf ears."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def _where(case: Case, name: str) -> str:
    """The stream as `redirect` knows it."""
    where = case.streams.get(name, "")
    return "/dev/full" if where == "full" else where


def _listen(readers: Mapping[str, int], process: int) -> tuple[dict[str, str], bool]:
    """What comes from each pipe until all are closed; a process that takes too long is killed with all it started."""
    said = dict.fromkeys(readers, b"")
    deadline, hung = time.monotonic() + GUARD, False
    with selectors.DefaultSelector() as selector:
        for name, reader in readers.items():
            selector.register(reader, selectors.EVENT_READ, name)
        while selector.get_map():
            ready = selector.select(max(0.0, deadline - time.monotonic()))
            if not ready and hung:
                break  # what keeps a pipe open is in another session: an orphan
            if not ready:
                hung, deadline = True, time.monotonic() + _GRACE
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process, signal.SIGKILL)
            for key, _ in ready:
                piece = os.read(key.fd, 1 << 16)
                said[key.data] += piece
                if not piece:
                    selector.unregister(key.fd)
    for reader in readers.values():
        os.close(reader)
    return {name: text.decode("utf-8", "replace") for name, text in said.items()}, hung


def _end_orphans() -> int:
    """How many processes a case has left, which are ended; those that were just killed may take their time to go."""
    deadline = time.monotonic() + _GRACE
    while _children() and time.monotonic() < deadline:
        _reap()
        time.sleep(0.001)
    ended = 0
    # the children of each that is killed are ours next
    while left := _children():
        for child in left:
            with contextlib.suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
        ended += len(left)
    return ended


def _children() -> list[int]:
    _reap()
    return [int(pid) for pid in Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()]


def _reap() -> None:
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
