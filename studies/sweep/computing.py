"""The parts of a sweep on the threads of this process."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait

from ...codegen.batch import CompiledLoop
from ..files.errors import ScenarioError
from .plan import Plan
from .points import compute_part
from .row import Rows

# what computes parts, in any order; once closed it computes no more
Computed = Generator[tuple[int, Rows], None, None]
Compute = Callable[[Plan, CompiledLoop, Iterable[int]], Computed]


class _StoppedError(Exception):
    """The sweep was ended from outside."""


def on_threads(workers: int | None = None) -> Compute:
    """Parts on the threads of this process, the interpreter's lock released; one per core by default."""
    count = cores() if workers is None else workers
    if count < 1:
        raise ScenarioError(f"workers must be at least 1, not {count}")

    def compute(plan: Plan, compiled: CompiledLoop, parts: Iterable[int]) -> Computed:
        stop, waiting = threading.Event(), iter(parts)

        def check(_: float) -> None:
            if stop.is_set():
                raise _StoppedError

        def work(part: int) -> tuple[int, Rows]:
            return part, compute_part(plan, compiled, part, check)

        with ThreadPoolExecutor(count) as pool:
            running: list[Future[tuple[int, Rows]]] = []
            try:
                while True:
                    # no more than twice the threads: a sweep of a million parts has no million futures
                    for part in waiting:
                        running.append(_submitted(pool, work, part))
                        if len(running) >= 2 * count:
                            break
                    if not running:
                        return
                    finished = wait(running, return_when=FIRST_COMPLETED).done
                    first, running = running, [future for future in running if future not in finished]
                    yield from (future.result() for future in first if future in finished)
            finally:
                stop.set()
                for future in running:
                    future.cancel()

    return compute


def _submitted(
    pool: ThreadPoolExecutor, work: Callable[[int], tuple[int, Rows]], part: int
) -> Future[tuple[int, Rows]]:
    try:
        return pool.submit(work, part)
    except RuntimeError as error:  # a limit of the system, or of its memory
        raise ScenarioError("the system refuses another thread; use fewer workers") from error


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
