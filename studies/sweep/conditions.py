"""The gain conditions of the observers at all points of a sweep."""

from __future__ import annotations

import numpy as np

from ...codegen.batch import Trace
from ...model.arrays import Array
from ...model.block import Block
from ...observers.conditions import violated
from ..simulate.conditions import conditions_of, facts
from .plan import Plan
from .region import where

# so many points are checked at once
_POINTS = 4096


def swept_conditions(wanted: Plan, truth: Trace) -> dict[str, list[str]]:
    """For each registered observer a sentence for each condition that does not hold at all points.

    The suprema are those of `truth`, the recorded run of the scenario itself.
    """
    known, result = facts(wanted.prepared, truth), {}
    points = np.arange(int(np.prod(wanted.axes.shape)))
    slices = [points[i : i + _POINTS] for i in range(0, len(points), _POINTS)]
    for block, conditions, every in conditions_of(wanted.prepared):
        found = [violated(conditions, every, _numbers(wanted, block, some, known)) for some in slices]
        broken = {name: np.concatenate([one[name] for one in found]) for name in found[0]}
        result[block.name] = [
            f"{name} does not hold {where(wanted.axes, at)}" for name, at in broken.items() if at.any()
        ]
    return {name: sentences for name, sentences in result.items() if sentences}


def _numbers(
    wanted: Plan, block: Block, points: np.ndarray[tuple[int], np.dtype[np.int64]], known: dict[str, float]
) -> Array:
    """(symbols × points) the numbers of `block` and the FACTS at some points."""
    runs = points * len(wanted.seeds)
    about = np.tile(list(known.values()), (len(runs), 1))
    for grid, which in wanted.on_grids(runs):
        about[which, list(known).index("h")] = grid.h
    return np.hstack([wanted.numbers(runs)[block.name], about]).T
