"""Interleaved rounds on one core, in CPU time."""

from __future__ import annotations

import math
import os
import statistics
import time
from collections.abc import Callable, Mapping, Sequence

ROUNDS = 7
# of a round of one contender, in CPU seconds
_ROUND = 0.4


def one_core() -> None:
    """Keep this process on one core; libraries that start threads see no other. Before they are imported."""
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[variable] = "1"
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def clock(work: Callable[[], object]) -> float:
    """CPU seconds of all threads."""
    start = time.process_time()
    work()
    return time.process_time() - start


def repeated(work: Callable[[], float]) -> Callable[[], float]:
    """Amount per CPU second, over as many calls of `work` (which returns an amount) as fill a round."""
    calls = max(1, math.ceil(_ROUND / max(clock(work), 1e-4)))

    def rate() -> float:
        amounts: list[float] = []
        seconds = clock(lambda: amounts.extend(work() for _ in range(calls)))
        return sum(amounts) / seconds

    return rate


def interleaved(
    rates: Mapping[str, Callable[[], float]], progress: Callable[[float], None], rounds: int = ROUNDS
) -> dict[str, list[float]]:
    """Each rate once a round, so that a slow moment of the machine hits all alike."""
    measured: dict[str, list[float]] = {name: [] for name in rates}
    for i in range(rounds):
        for j, (name, rate) in enumerate(rates.items()):
            progress((i + j / len(rates)) / rounds)
            measured[name].append(rate())
    return measured


def ratio(above: Sequence[float], below: Sequence[float]) -> float:
    """The median over the rounds of the ratio within each."""
    return statistics.median(a / b for a, b in zip(above, below, strict=True))
