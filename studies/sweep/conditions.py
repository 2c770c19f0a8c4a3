"""The gain conditions of the observers at all points of a sweep."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...codegen.batch import Trace
from ...model.arrays import Array
from ...model.block import Block
from ...observers.conditions import Truths, violated
from ..simulate.conditions import conditions_of, facts
from .axes import Axes
from .plan import Plan
from .region import where

# so many points are checked at once
_POINTS = 4096


# observer → condition → (points) where it does not hold; only those that do not hold somewhere
Violated = Mapping[str, Mapping[str, Truths]]


def swept_conditions(plan: Plan, truth: Trace) -> Violated:
    """The gain conditions of each registered observer that do not hold somewhere.

    The suprema are those of `truth`, the recorded run of the scenario itself.
    """
    known, result = facts(plan.prepared, truth), {}
    points = np.arange(plan.axes.size)
    slices = [points[i : i + _POINTS] for i in range(0, len(points), _POINTS)]
    for block, conditions, names in conditions_of(plan.prepared):
        pieces = [violated(conditions, names, _numbers(plan, block, some, known)) for some in slices]
        broken = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}
        result[block.name] = {name: at for name, at in broken.items() if at.any()}
    return {name: broken for name, broken in result.items() if broken}


def sentences(axes: Axes, broken: Violated) -> dict[str, list[str]]:
    """For each observer a sentence for each condition that does not hold at all points."""
    return {
        observer: [f"{name} does not hold {where(axes, at)}" for name, at in conditions.items()]
        for observer, conditions in broken.items()
    }


def by_point(axes: Axes, broken: Violated) -> dict[str, xr.DataArray]:
    """`condition_violated` (condition, points of the sweep) in the order of the sentences; nothing if all hold."""
    each = [(observer, name, at) for observer, conditions in broken.items() for name, at in conditions.items()]
    if not each:
        return {}
    observers, names, where_not = zip(*each, strict=True)
    return {
        "condition_violated": xr.DataArray(
            np.stack(where_not).reshape(len(each), *axes.shape),
            dims=("condition", *axes.dimensions),
            coords={"condition": list(names), "condition_observer": ("condition", list(observers))},
            attrs={"long_name": "whether a gain condition of an observer does not hold"},
        )
    }


def _numbers(plan: Plan, block: Block, points: NDArray[np.int64], known: dict[str, float]) -> Array:
    """(symbols × points) the numbers of `block` and the FACTS at some points."""
    runs = points * len(plan.seeds)
    about = np.tile(list(known.values()), (len(runs), 1))
    for grid, which in plan.on_grids(runs):
        about[which, list(known).index("h")] = grid.h
    return np.hstack([plan.numbers_of(block, runs), about]).T
