"""What no observer can beat: the smoother, which knows what comes, and the posterior bound of causal estimates."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import xarray as xr

from ...model.arrays import Array
from ...model.symbols import hat
from ...observers.behind.spread import sd
from ..estimate.of_scenario import sampled
from ..estimate.run import KALMAN
from ..files.progress import CountedProgress, unseen
from ..kalman.run import INPUTS, How, passed
from ..scenarios.layers import Value
from ..simulate.run import simulate

SMOOTHER, BOUND = "smoother", "bound"


def lines(
    source: str,
    changes: Mapping[str, Value],
    quantities: Sequence[str],
    seeds: Sequence[int],
    progress: CountedProgress,
) -> xr.DataArray:
    """(seed, line, quantity): RMSE of the smoother, and the root mean square of the Kalman filter's own sd.

    The filter's covariance is the Riccati equation's along the true lengths, nearly: the Cramér–Rao bound of causal
    estimates, on average over the inputs that its chains of integrators would draw; one of them may be easier.
    """
    rows = []
    for done, seed in enumerate(seeds):
        progress(done, len(seeds))
        of = sampled(source, {**changes, "seed": seed})
        start = json.loads(of.run.attrs["parameters"])["score.start"]
        late, true = of.record.tau >= start, _signals(of.run)
        smooth = passed(of.record, How(INPUTS, None), {}, 1, unseen).outputs
        errors = [_root_mean_square(smooth[hat(name)][late] - true[name][late]) for name in quantities]
        filtered = simulate(source, KALMAN, {**changes, "seed": seed}).isel(observer=0)
        sds = _signals(filtered.sel(time=slice(start, None)), sd)
        rows.append([errors, [_root_mean_square(sds[name]) for name in quantities]])
    coordinates = {"seed": list(seeds), "line": [SMOOTHER, BOUND], "quantity": list(quantities)}
    return xr.DataArray(np.array(rows), coordinates, ("seed", "line", "quantity"))


def _signals(run: xr.Dataset, variable: Callable[[str], str] = str) -> dict[str, Array]:
    """Each quantity of a run, or what `variable` makes of the names x, u, a and Delta."""
    x, Delta = run[variable("x")], run[variable("Delta")]
    states = {name: x.sel(state=name).values for name in run.state.values.tolist()}
    of_muscles = {f"{kind}{j}": run[variable(kind)].isel(muscle=j - 1).values for kind in ("u", "a") for j in (1, 2)}
    return {**states, **of_muscles, "Delta": Delta.values}


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
