"""The numbers that an error table shows, from the sums that the score has taken."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np
import xarray as xr
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
    sums = np.array(np.broadcast_arrays(*score.values()), dtype=float)
    shape = sums.shape[1:]
    formula = measures_of(tuple(score), tuple(quantities), tuple(names))
    table = formula(sums.reshape(len(score), -1), grid.h, grid.steps, grid.window).full()
    rows = iter(table.reshape(-1, *shape))
    return {measure: {name: next(rows) for name in quantities} for measure in names}


@functools.lru_cache(maxsize=64)
def measures_of(score: tuple[str, ...], quantities: tuple[str, ...], names: tuple[str, ...]) -> ca.Function:
    """measures(sums, h, steps, window) → measure by measure, each of all quantities.

    score: the names of the sums. The rest is of the grid of the points at which errors count.
    """
    column, h, steps, window = ca.SX.sym("sums", len(score)), ca.SX.sym("h"), ca.SX.sym("steps"), ca.SX.sym("window")
    sums = dict(zip(score, ca.vertsplit(column), strict=True))
    end, points = steps * h, ca.fmax(0, steps - window + 1)

    def value(measure: str, name: str) -> ca.SX:
        owner = counted_with(name)
        if measure == "rmse":
            # RMSE = √(Σ error²/n),  n the points at which the tendon was taut; 0/0 is NaN
            return ca.sqrt(sums[f"{name}.squares"] / sums[f"{owner}.count"])
        if measure == "peak":
            return sums[f"{name}.peak"]
        if measure == "settling":
            settling = sums[f"{name}.settling"]
            return ca.if_else(settling > end - h / 2, math.nan, settling)
        if measure == "masked":
            return (points - sums[f"{owner}.count"]) * h
        # mean |v̂((k+1)T_s) − v̂(k T_s)|
        return sums[f"{name}.chatter"] / sums[f"{owner}.pairs"] if chatters(name) else ca.SX(math.nan)

    table = ca.vertcat(*(value(measure, name) for measure in names for name in quantities))
    arguments, given = [column, h, steps, window], ["sums", "h", "steps", "window"]
    return ca.Function("measures", arguments, [ca.densify(table)], given, ["values"])


def numbers(measure: xr.DataArray) -> dict[tuple[str, str], float]:
    """(estimator, quantity) → number. To ask xarray for each takes longer than the run."""
    table = measure.transpose("estimator", "quantity")
    names = itertools.product(table.estimator.values.tolist(), table.quantity.values.tolist())
    return dict(zip(names, table.values.ravel().tolist(), strict=True))
