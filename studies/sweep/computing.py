"""The numbers of the parts of a sweep, on the threads of this process."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait

import numpy as np

from ...codegen.batch import CompiledLoop
from ...model.arrays import Array
from ..files.errors import ScenarioError
from ..files.progress import Progress, unseen
from ..simulate.measures import measures
from .causes import cause_of, causes
from .dataset import width
from .plan import Plan

# what computes parts, in any order; once closed it computes no more
Computed = Generator[tuple[int, Array], None, None]
Compute = Callable[[Plan, CompiledLoop, Iterable[int]], Computed]


class _StoppedError(Exception):
    """The sweep was ended from outside."""


def on_threads(workers: int | None = None) -> Compute:
    """Parts on the threads of this process, the interpreter's lock released; one per core by default."""
    count = cores() if workers is None else workers
    if count < 1:
        raise ScenarioError(f"workers must be at least 1, not {count}")

    def compute(wanted: Plan, compiled: CompiledLoop, parts: Iterable[int]) -> Computed:
        stop, waiting = threading.Event(), iter(parts)

        def check(_: float) -> None:
            if stop.is_set():
                raise _StoppedError

        def work(part: int) -> tuple[int, Array]:
            return part, compute_part(wanted, compiled, part, check)

        with ThreadPoolExecutor(count) as pool:
            running: list[Future[tuple[int, Array]]] = []
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
    pool: ThreadPoolExecutor, work: Callable[[int], tuple[int, Array]], part: int
) -> Future[tuple[int, Array]]:
    try:
        return pool.submit(work, part)
    except RuntimeError as error:  # a limit of the system, or of its memory
        raise ScenarioError("the system refuses another thread; use fewer workers") from error


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1


def compute_part(wanted: Plan, compiled: CompiledLoop, part: int, progress: Progress = unseen) -> Array:
    """The numbers of one part: (runs × numbers) as `sweep_dataset` reads them."""
    runs = wanted.members(part)
    parameters = wanted.numbers(runs)
    result = np.empty((len(runs), width(wanted)))
    names, every = list(compiled.loop.score.x), causes(compiled.loop, wanted.observers)
    blocks = {block.name: block for block in (compiled.loop.truth, *compiled.loop.observers)}
    for grid, which in wanted.on_grids(runs):
        own = {name: values[which] for name, values in parameters.items()}
        seeds = wanted.seeds[runs[which] % len(wanted.seeds)]
        outcomes = compiled.batch(grid, seeds, own, wanted.observers, progress)
        columns: list[Array] = []
        for observer in wanted.observers:
            outcome = outcomes[observer]
            sums = dict(zip(names, outcome.sums.T, strict=True))
            points, end = max(0, grid.steps - grid.window + 1), grid.steps * grid.h
            found = measures(sums, points, grid.h, end, wanted.quantities, wanted.measures)
            columns += [found[kind][quantity] for kind in wanted.measures for quantity in wanted.quantities]
            columns += [_time(outcome.failed, grid.h), cause_of(blocks[observer], outcome, every).astype(float)]
        plant = outcomes[compiled.loop.truth.name]
        columns += [_time(plant.failed, grid.h), cause_of(compiled.loop.truth, plant, every).astype(float)]
        result[which] = np.stack(columns, axis=1)
    return result


def _time(failed: Array | np.ndarray[tuple[int, ...], np.dtype[np.int64]], h: float) -> Array:
    return np.where(failed < 0, np.nan, failed * h)
