"""The numbers that an error table shows, from the sums that the score has taken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...codegen.memory import Grid
from ...model.arrays import Array
from ...observers.score import chatters, counted_with

# measure → what it is; a recorded run has all, a sweep those of the score
SENTENCES: Mapping[str, str] = {
    "rmse": "root of the mean squared error over [score.start, T]",
    "peak": "largest |error| over [0, T]",
    "settling": "last time the error exceeded its tolerance; NaN if it still does at the end",
    "chattering": "mean change of the estimate from sample to sample over [score.start, T]",
    "masked": "time within [score.start, T] in which the tendon was slack and the quantity did not count",
}


def measures(
    score: Mapping[str, ArrayLike],
    grid: Grid,
    quantities: Sequence[str],
    names: Sequence[str] = tuple(SENTENCES),
) -> dict[str, dict[str, Array]]:
    """Measure → quantity → how well it was estimated, in one run or many on `grid`; NaN where it is not defined.

    grid: that of the points at which errors count. score: the sums that the kernel has taken, numbers or (runs);
    names: the measures.
    """
    sums = {name: np.asarray(total, dtype=float) for name, total in score.items()}
    h, end = grid.h, grid.steps * grid.h
    window_points = max(0, grid.steps - grid.window + 1)

    def value(measure: str, name: str) -> Array:
        owner = counted_with(name)
        if measure == "rmse":
            # RMSE = √(Σ error²/n),  n the points at which the tendon was taut
            return np.sqrt(_ratio(sums[f"{name}.squares"], sums[f"{owner}.count"]))
        if measure == "peak":
            return sums[f"{name}.peak"]
        if measure == "settling":
            settling = sums[f"{name}.settling"]
            return np.where(settling > end - h / 2, np.nan, settling)
        if measure == "masked":
            return (window_points - sums[f"{owner}.count"]) * h
        if not chatters(name):
            return np.full_like(next(iter(sums.values())), np.nan)
        # mean |v̂((k+1)T_s) − v̂(k T_s)|
        return _ratio(sums[f"{name}.chatter"], sums[f"{owner}.pairs"])

    return {measure: {name: value(measure, name) for name in quantities} for measure in names}


def _ratio(total: Array, count: Array) -> Array:
    """The mean; NaN of nothing."""
    return np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0)
