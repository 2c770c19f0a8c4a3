"""SIGINT, SIGTERM and SIGHUP end a command in the same way, whatever it is doing: a sentence and 128 + the number.

Imported before all else, so it imports next to nothing: CasADi and xarray take seconds, in which a signal may come.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import signal
import sys
import time
from collections.abc import Callable
from types import FrameType

_WATCHED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# a shell adds the number of the signal
_STATUS = 128
_AGAIN = 0.05  # seconds between two looks whether somebody has swallowed the exception
_SOON = 0.001  # the same, where somebody has said so: not while that is being said
_PATIENCE = 30.0  # seconds that cleaning up may take


class Stopped(BaseException):
    """A signal has come; a note says what of the work is kept."""


def stoppable(command: Callable[[], None]) -> None:
    """Run a command; the first of the signals that comes raises Stopped in it, the others change nothing.

    The exception comes again until it gets here: a destructor, a callback of C or an `except:` in some library may
    swallow it. What nohup or a shell has made deaf to a signal stays so. Only for the main thread of a process that
    ends with the command: from then on signals are ignored.
    """
    _Stoppable().run(command)


class _Stoppable:
    def __init__(self) -> None:
        self._watched = [n for n in _WATCHED if signal.getsignal(n) != signal.SIG_IGN]
        self._number = 0  # of the signal that came first
        self._since = 0.0
        self._notes: list[str] = []
        self._over = False

    def run(self, command: Callable[[], None]) -> None:
        # the first to be registered runs last
        atexit.register(self._leave)
        try:
            sys.unraisablehook = self._tell_unraisable
            for number in self._watched:
                signal.signal(number, self._handle)
            command()
        except Stopped as stopped:
            self._over = True
            self._notes = getattr(stopped, "__notes__", [])
        finally:
            # before any call: Python looks for signals at calls, and what comes now finds nobody to catch it
            self._over = True
            signal.setitimer(signal.ITIMER_REAL, 0)
            # Python's own end sets the default again, with which a late signal would kill
            for number in self._watched:
                signal.signal(number, signal.SIG_IGN)
            if self._number:
                _say("; ".join(["stopped", *self._notes]))
                sys.exit(_STATUS + self._number)

    def _leave(self) -> None:
        # a library that the signal has left half imported may abort what Python still does
        if self._number:
            for stream in (sys.stdout, sys.stderr):
                with contextlib.suppress(OSError, ValueError):
                    if stream:
                        stream.flush()
            os._exit(_STATUS + self._number)

    def _tell_unraisable(self, unraisable: sys.UnraisableHookArgs) -> None:
        if not self._number:
            sys.__unraisablehook__(unraisable)
        elif not self._over:
            # Stopped itself was swallowed, or the destructor of what was half made when it came has failed
            signal.setitimer(signal.ITIMER_REAL, _SOON, _AGAIN)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self._over:
            return
        if not self._number:
            self._number, self._since = number, time.monotonic()
            signal.signal(signal.SIGALRM, self._handle)
            signal.setitimer(signal.ITIMER_REAL, _AGAIN, _AGAIN)
        if time.monotonic() - self._since > _PATIENCE:
            os._exit(_STATUS + self._number)
        if not _is_handled(sys.exception()):
            raise Stopped


def _is_handled(error: BaseException | None) -> bool:
    """Whether somebody cleans up because of Stopped just now, and will raise it further."""
    while error is not None and not isinstance(error, Stopped):
        error = error.__context__
    return error is not None


def _say(sentence: str) -> None:
    # without click, which may be half imported; a closed stream is None, and without a listener the exit code says it
    if sys.stderr:
        with contextlib.suppress(OSError):
            print(f"hillobs: {sentence}", file=sys.stderr, flush=True)
