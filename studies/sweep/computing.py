"""The parts of a sweep on the threads of this process."""

from __future__ import annotations

import contextlib
import itertools
import os
import queue
import sys
import threading
import warnings
from collections.abc import Callable, Generator, Iterable

from ...codegen.batch import CompiledLoop
from ...codegen.system.room import THREAD, has_room
from ..files.errors import ScenarioError
from .plan import Plan
from .points import compute_part
from .row import Rows

# what computes parts, in any order; once closed it computes no more
Computed = Generator[tuple[int, Rows], None, None]
Compute = Callable[[Plan, CompiledLoop, Iterable[int]], Computed]
_Ended = tuple[int, Rows | BaseException]

_LOOK = 1.0  # seconds between two looks whether the threads live
_AHEAD = 2  # parts given out for each thread


class SweepWarning(UserWarning):
    """Something about a sweep that is mended, and should be known."""


class _StoppedError(Exception):
    """The sweep was ended from outside."""


def on_threads(workers: int | None = None) -> Compute:
    """Parts on the threads of this process, the interpreter's lock released; one per core by default.

    As many threads as the system grants; one worker needs none. ScenarioError for a number below 1.
    """
    count = cores() if workers is None else workers
    if count < 1:
        raise ScenarioError(f"workers must be at least 1, not {count}")

    def compute(plan: Plan, compiled: CompiledLoop, parts: Iterable[int]) -> Computed:
        waiting, stop, threads = iter(parts), threading.Event(), list[threading.Thread]()
        given: queue.SimpleQueue[int | None] = queue.SimpleQueue()
        ended: queue.SimpleQueue[_Ended] = queue.SimpleQueue()

        def check(_: float) -> None:
            if stop.is_set():
                raise _StoppedError

        def work() -> None:
            while (part := given.get()) is not None:
                try:
                    ended.put((part, compute_part(plan, compiled, part, check)))
                except BaseException as error:
                    ended.put((part, error))

        try:
            if count > 1:
                _start(threads, work, count)
            if not threads:
                yield from ((part, compute_part(plan, compiled, part)) for part in waiting)
            running = 0
            while True:
                # a sweep of a million parts has no million of them in a queue
                for part in itertools.islice(waiting, _AHEAD * len(threads) - running):
                    given.put(part)
                    running += 1
                if not running:
                    return
                part, rows = _next(ended, threads)
                running -= 1
                if isinstance(rows, BaseException):
                    raise rows
                yield part, rows
        finally:
            stop.set()
            for _ in threads:
                given.put(None)
            for thread in threads:
                if thread.ident:
                    thread.join()

    return compute


def _start(threads: list[threading.Thread], work: Callable[[], None], count: int) -> None:
    """Start threads and append them, `count` or as many as the system grants; with a warning if they are fewer."""
    while len(threads) < count:
        threads.append(threading.Thread(target=work))
        try:
            # a thread that dies for want of memory before it begins is waited for without end
            if not has_room(THREAD):
                raise MemoryError
            threads[-1].start()
        except (RuntimeError, MemoryError):
            threads.pop()
            message = f"the system grants {len(threads)} of {count} threads; the sweep takes longer"
            warnings.warn(message, SweepWarning, stacklevel=2)
            return


def _next(ended: queue.SimpleQueue[_Ended], threads: list[threading.Thread]) -> _Ended:
    """What a thread has ended with. MemoryError if one of them has died without a word."""
    while True:
        with contextlib.suppress(queue.Empty):
            return ended.get(timeout=_LOOK)
        if not all(thread.is_alive() for thread in threads):
            raise MemoryError


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
