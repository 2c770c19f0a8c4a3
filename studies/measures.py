"""The numbers that an error table shows, from the sums that the score has taken."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ..model.symbols import QUANTITIES
from ..observers.score import CHATTERING, counted_with


@dataclass(frozen=True)
class Measure:
    """How well one quantity was estimated; NaN where the window is empty or the observer failed."""

    rmse: float  # over [score.start, T]
    peak: float  # over [0, T]
    settling: float  # last time the error exceeded its tolerance; NaN if it still does at the end
    chattering: float  # mean |v̂((k+1)T_s) − v̂(k T_s)| over [score.start, T]; NaN where it is not defined
    masked: float  # time within [score.start, T] in which the tendon was slack


def measures(score: Mapping[str, float], window_points: int, h: float, end: float) -> dict[str, Measure]:
    """A Measure per quantity. window_points: grid points in the window; h: step; end: last time of the run."""
    return {name: _measure(name, score, window_points, h, end) for name in QUANTITIES}


def _measure(name: str, score: Mapping[str, float], window_points: int, h: float, end: float) -> Measure:
    whose = counted_with(name)
    count, settling = score[f"{whose}.count"], score[f"{name}.settling"]
    # RMSE = √(Σ error²/n),  n the points at which the tendon was taut
    rmse = math.sqrt(score[f"{name}.squares"] / count) if count else math.nan
    chattering = math.nan
    if name in CHATTERING and (pairs := score[f"{whose}.pairs"]) > 0:
        chattering = score[f"{name}.chatter"] / pairs
    return Measure(
        rmse=rmse,
        peak=score[f"{name}.peak"],
        settling=math.nan if settling > end - h / 2 else settling,
        chattering=chattering,
        masked=(window_points - count) * h,
    )
