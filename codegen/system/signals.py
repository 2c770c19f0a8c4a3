"""Signals that come while a process is being started wait until there is something to end."""

from __future__ import annotations

import signal
import threading
from types import FrameType

# with the timer that repeats them for those who swallow exceptions
_WATCHED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGALRM)


class HeldSignals:
    """From here to `release` the handlers of Python are not called; then they are, for what has come."""

    def __init__(self) -> None:
        self._came: list[int] = []
        # only the main thread may have handlers, and only there do they interrupt anything
        here = threading.current_thread() is threading.main_thread()
        handlers = {number: signal.getsignal(number) for number in _WATCHED if here}
        self._before = {number: handler for number, handler in handlers.items() if callable(handler)}
        for number in self._before:
            signal.signal(number, self._note)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._came.append(number)

    def release(self) -> None:
        """Let the handlers act again; the second time it does nothing."""
        before, self._before = self._before, {}
        for number, handler in before.items():
            signal.signal(number, handler)
        came, self._came = self._came, []
        for signaled in came:
            signal.raise_signal(signaled)
