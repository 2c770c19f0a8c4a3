"""The numbers that an error table shows, from the sums that the score has taken."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..codegen.library import Array
from ..model.symbols import QUANTITIES
from ..observers.score import CHATTERING, counted_with


@dataclass(frozen=True)
class Measure:
    """How well one quantity was estimated, in one run or many; NaN where the window is empty or the observer failed."""

    rmse: Array  # over [score.start, T]
    peak: Array  # over [0, T]
    settling: Array  # last time the error exceeded its tolerance; NaN if it still does at the end
    chattering: Array  # mean |v̂((k+1)T_s) − v̂(k T_s)| over [score.start, T]; NaN where it is not defined
    masked: Array  # time within [score.start, T] in which the tendon was slack


def measures(score: Mapping[str, ArrayLike], window_points: int, h: float, end: float) -> dict[str, Measure]:
    """A Measure per quantity. window_points: grid points in the window; h: step; end: last time of the run."""
    sums = {name: np.asarray(value, dtype=float) for name, value in score.items()}
    return {name: _measure(name, sums, window_points, h, end) for name in QUANTITIES}


def _measure(name: str, score: Mapping[str, Array], window_points: int, h: float, end: float) -> Measure:
    whose = counted_with(name)
    count, settling = score[f"{whose}.count"], score[f"{name}.settling"]
    chattering = np.full_like(settling, np.nan)
    if name in CHATTERING:
        chattering = _ratio(score[f"{name}.chatter"], score[f"{whose}.pairs"])
    return Measure(
        # RMSE = √(Σ error²/n),  n the points at which the tendon was taut
        rmse=np.sqrt(_ratio(score[f"{name}.squares"], count)),
        peak=score[f"{name}.peak"],
        settling=np.where(settling > end - h / 2, np.nan, settling),
        chattering=chattering,
        masked=(window_points - count) * h,
    )


def _ratio(total: Array, count: Array) -> Array:
    """The mean; NaN of nothing."""
    return np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0)
