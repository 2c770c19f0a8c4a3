"""Whether the cost is linear in runs and in time, and how much memory a run takes."""

from __future__ import annotations

import contextlib
import multiprocessing
import resource
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from hillobs.codegen.batch import compile_loop

from .problem import problem
from .timing import clock

# runs, and length of a run in time units
SIZES = ((64, 20), (256, 20), (1024, 20), (1024, 2), (256, 8), (64, 80))
_REPEATS = 3
_FEW, _MANY, _MEMORY_STEPS = 1024, 33_792, 10


def times() -> Iterator[tuple[int, int, float]]:
    """Runs, length, and CPU seconds (the best of some)."""
    of = problem()
    compiled = compile_loop(of.loop)
    for runs, length in SIZES:
        grid = replace(of.grid, steps=round(length / of.grid.h))
        work = partial(compiled.batch, grid, np.arange(runs, dtype=np.uint64), of.numbers, of.names)
        yield runs, length, min(clock(work) for _ in range(_REPEATS))


def memory() -> tuple[float, float]:
    """Bytes of results and bytes of the process, per run."""
    (few, _), (many, results) = (_in_a_process(runs) for runs in (_FEW, _MANY))
    return results / _MANY, (many - few) / (_MANY - _FEW)


def _in_a_process(runs: int) -> tuple[int, int]:
    # a process of its own, because a peak never falls
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(_peak_and_results, runs).result()


def _peak_and_results(runs: int) -> tuple[int, int]:
    of = problem()
    grid = replace(of.grid, steps=_MEMORY_STEPS)
    outcomes = compile_loop(of.loop).batch(grid, np.arange(runs, dtype=np.uint64), of.numbers, of.names)
    results = sum(o.sums.nbytes + o.failed.nbytes + o.cause.nbytes for o in outcomes.values())
    return _peak(), results


def _peak() -> int:
    """Bytes that this process has needed at most."""
    # Linux's ru_maxrss begins at what the parent had
    with contextlib.suppress(OSError):
        status = Path("/proc/self/status").read_text("ascii", "replace").split()
        return int(status[status.index("VmHWM:") + 1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
