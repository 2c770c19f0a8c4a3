"""A signal ends a command whatever it is doing: nothing that swallows exceptions keeps it running."""

import signal
import subprocess
import textwrap
from pathlib import Path

import pytest

from command_line import in_a_process
from hillobs.studies.cli.main import _COMMANDS
from hillobs.studies.sweep.run import sweep

# `stop` sends the signal; what it raises is swallowed in every place here but the first and the last
PLACES = {
    "plain code": "stop()",
    "a destructor": """
class Dropped:
    def __del__(self):
        stop()
Dropped()
""",
    "a weak reference": """
class Referred: ...
referred = Referred()
reference = weakref.ref(referred, lambda _: stop())
del referred
""",
    "a generator that is dropped": """
def generate():
    try:
        yield
    finally:
        stop()
next(generate())
""",
    "a callback of C": """
kind = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
numbers = (ctypes.c_int * 2)(2, 1)
ctypes.CDLL(None).qsort(numbers, 2, ctypes.sizeof(ctypes.c_int), kind(lambda a, b: stop() or 0))
""",
    "a bare except": """
try:
    stop()
except:
    pass
""",
    "an except that keeps it": """
kept = []
try:
    stop()
except BaseException as error:
    kept.append(error)
""",
    "a future": """
concurrent.futures.Future().add_done_callback(lambda _: None)
future = concurrent.futures.Future()
try:
    stop()
except BaseException as error:
    future.set_exception(error)
""",
    "an except that raises something else": """
try:
    stop()
except BaseException as error:
    raise ImportError("cannot be imported") from error
""",
}

PROGRAM = """
import atexit, concurrent.futures, ctypes, os, signal, time, weakref
from hillobs.studies.cli.shell import stopping

def stop(number=signal.{name}):
    os.kill(os.getpid(), number)

def command():
{body}
    for _ in range(1000):
        time.sleep(0.01)
    print("ran on")

{before}
stopping.stoppable(command)
"""
SIGNALS = ["SIGINT", "SIGTERM", "SIGHUP"]


def run(body: str, name: str = "SIGINT", before: str = "") -> subprocess.CompletedProcess[str]:
    program = PROGRAM.format(name=name, body=textwrap.indent(body, "    "), before=before)
    return in_a_process("-c", program, timeout=60)


@pytest.mark.parametrize("name", SIGNALS)
@pytest.mark.parametrize("place", PLACES)
def test_a_signal_ends_a_command_in(place: str, name: str) -> None:
    done = run(PLACES[place], name)
    assert (done.returncode, done.stdout, done.stderr) == (128 + getattr(signal, name), "", "hillobs: stopped\n")


CLEANING = """
try:
    stop()
finally:
    stop()
    time.sleep(4 * stopping._AGAIN)
    stop(signal.SIGTERM)
    print("clean")
"""


def test_what_comes_while_it_cleans_up_changes_nothing() -> None:
    done = run(CLEANING)
    assert (done.returncode, done.stdout, done.stderr) == (130, "clean\n", "hillobs: stopped\n")


def test_cleaning_up_that_never_ends_is_ended() -> None:
    for_ever = "try:\n    stop()\nfinally:\n    threading.Event().wait()"
    done = run(for_ever, before="stopping._PATIENCE = 0.2; import threading")
    assert (done.returncode, done.stdout) == (130, "")


def test_a_signal_after_the_end_changes_nothing() -> None:
    """Not even when the interpreter has put the default of the system back, which kills."""
    late = "class Late:\n    def __del__(self): stop()\natexit.register(stop); late = Late()"
    done = run("return", before=late)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_nothing_that_was_left_half_done_can_abort_the_end() -> None:
    """What is destroyed at Python's own end is not, once it was stopped; what was to be done at the end is."""
    aborts = "class Half:\n    def __del__(self): os.abort()\nhalf = Half()"
    done = run("print('begun'); atexit.register(print, 'done'); stop()", before=aborts)
    assert (done.returncode, done.stdout, done.stderr) == (130, "begun\ndone\n", "hillobs: stopped\n")


@pytest.mark.parametrize("name", SIGNALS)
def test_what_nohup_or_a_shell_has_made_deaf_stays_so(name: str) -> None:
    done = run(
        "stop(); print('went on', flush=True); os._exit(0)",
        before=f"signal.signal(signal.{name}, signal.SIG_IGN)",
        name=name,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "went on\n", "")


def test_from_python_ctrl_c_is_the_callers() -> None:
    """Only the command line has handlers of its own."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            sweep(changes={"duration": 0.2}, progress=lambda done, of: signal.raise_signal(signal.SIGINT))
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)


# the signal comes in a callback of the import system, where Python drops whatever is raised
STRUCK = """
import os, signal, sys
at, sys.argv = int(sys.argv[1]), ["hillobs", *sys.argv[2:]]

def strike(frame, event, _):
    global at
    if event == "call" and frame.f_code.co_name == "cb" and "importlib" in frame.f_code.co_filename:
        at -= 1
        if not at:
            sys.setprofile(None)
            os.kill(os.getpid(), signal.SIGINT)

from hillobs.__main__ import main
sys.setprofile(strike)
main()
"""
WORDS = {
    "simulate": "simulate paper-clean",
    "sweep": "sweep --over plant.m=1,1.1",
    "tune": "tune --observer high_gain",
    "estimate": "estimate no.csv --muscles no.toml",
    "calibrate": "calibrate no.toml --muscles no.toml",
    "live": "live --muscles no.toml",
    "import": "import no.osim",
    "fit": "fit paper-clean",
    "export": "export c --observer high_gain --period 0.005 --out c",
    "observability": "observability",
    "figures": "figures no.nc",
    "curves": "curves",
    "errata": "errata",
    "show": "show challenge",
    "list": "list",
    "docs": "docs",
    "info": "info",
    "clean": "clean",
}


def test_every_command_is_struck() -> None:
    assert list(WORDS) == list(_COMMANDS)


@pytest.mark.parametrize("command", WORDS)
def test_a_signal_during_start_up_is_not_lost(command: str, tmp_path: Path) -> None:
    """In each command somewhere else: dozens of modules are imported before it begins."""
    at = 10 + 5 * list(WORDS).index(command)
    done = in_a_process("-c", STRUCK, str(at), *WORDS[command].split(), timeout=120, HILLOBS_CACHE=str(tmp_path))
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "hillobs: stopped\n")
