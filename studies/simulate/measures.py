"""The numbers that an error table shows, from the sums that the score has taken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...model.arrays import Array
from ...model.symbols import QUANTITIES
from ...observers.score import CHATTERING, MEASURES, counted_with

# of a recorded run; a sweep takes those of the score
KINDS: Mapping[str, str] = {
    "rmse": "root of the mean squared error over [score.start, T]",
    "peak": "largest |error| over [0, T]",
    "settling": "last time the error exceeded its tolerance; NaN if it still does at the end",
    "chattering": "mean change of the estimate from sample to sample over [score.start, T]",
    "masked": "time within [score.start, T] in which the tendon was slack and the quantity did not count",
}


def measures(
    score: Mapping[str, ArrayLike],
    window_points: int,
    h: float,
    end: float,
    quantities: Sequence[str] = QUANTITIES,
    kinds: Sequence[str] = (*MEASURES, "masked"),
) -> dict[str, dict[str, Array]]:
    """Kind → quantity → how well it was estimated, in one run or many; NaN where it is not defined.

    window_points: grid points in the window; h: step; end: last time of the run.
    """
    sums = {name: np.asarray(value, dtype=float) for name, value in score.items()}

    def one(kind: str, name: str) -> Array:
        whose = counted_with(name)
        if kind == "rmse":
            # RMSE = √(Σ error²/n),  n the points at which the tendon was taut
            return np.sqrt(_ratio(sums[f"{name}.squares"], sums[f"{whose}.count"]))
        if kind == "peak":
            return sums[f"{name}.peak"]
        if kind == "settling":
            settling = sums[f"{name}.settling"]
            return np.where(settling > end - h / 2, np.nan, settling)
        if kind == "masked":
            return (window_points - sums[f"{whose}.count"]) * h
        if name not in CHATTERING:
            return np.full_like(next(iter(sums.values())), np.nan)
        # mean |v̂((k+1)T_s) − v̂(k T_s)|
        return _ratio(sums[f"{name}.chatter"], sums[f"{whose}.pairs"])

    return {kind: {name: one(kind, name) for name in quantities} for kind in kinds}


def _ratio(total: Array, count: Array) -> Array:
    """The mean; NaN of nothing."""
    return np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0)
