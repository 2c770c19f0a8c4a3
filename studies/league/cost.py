"""What an observer costs: its time per step, many runs at a time."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...codegen.batch import CompiledLoop, compile_loop
from ...observers import OBSERVERS
from ..sweep.plan import Plan, plan
from .cells import HOME

# runs abreast fill the lanes of a core four times; repetitions, of which the fastest counts
_RUNS, _TIMES = 64, 5
_DURATION = 2.0


def cost() -> dict[str, float]:
    """Observer → nanoseconds per step of one run on one core, beyond what truth and sensors take."""
    checked = plan(HOME.source, {}, _RUNS, list(OBSERVERS), {**HOME.changes, "duration": _DURATION})
    compiled = compile_loop(checked.loop)
    teams: list[tuple[str, ...]] = [(), *((name,) for name in OBSERVERS)]
    # in turns, so that a busy moment hits all alike
    seconds = np.array([[_seconds(checked, compiled, team) for team in teams] for _ in range(_TIMES)]).min(axis=0)
    steps = _RUNS * checked.prepared.grid.steps
    return dict(zip(OBSERVERS, (1e9 * (seconds[1:] - seconds[0]) / steps).tolist(), strict=True))


def _seconds(checked: Plan, compiled: CompiledLoop, team: Sequence[str]) -> float:
    alone = replace(checked, observers=tuple(team))
    runs = alone.members(0)
    start = time.perf_counter()
    compiled.batch(alone.prepared.grid, alone.seeds_of(runs), alone.numbers(runs), team)
    return time.perf_counter() - start
