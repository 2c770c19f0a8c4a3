"""What no observer can beat: the smoother, which knows what comes, and the posterior bound of causal estimates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ...model.symbols import hat
from ..estimate.of_scenario import sampled
from ..files.progress import CountedProgress, unseen
from ..kalman.run import INPUTS, How, passed
from ..scenarios.layers import Value

SMOOTHER, BOUND = "smoother", "bound"
# τ that do not count, as in the scenario
_START = 2.0


def lines(
    source: str,
    changes: Mapping[str, Value],
    quantities: Sequence[str],
    seeds: Sequence[int],
    progress: CountedProgress,
) -> xr.DataArray:
    """(line, quantity, seed): RMSE of the smoother, and the root mean square of the causal filter's own sd.

    The filter's covariance is the Riccati equation's along the true lengths, nearly: the Cramér–Rao bound of the chains
    that it takes Δ and u for. A drift of the forces is not in it, and noise that is not Gaussian can be done better by.
    """
    rows = []
    for done, seed in enumerate(seeds):
        progress(done, len(seeds))
        of = sampled(source, {**changes, "seed": seed})
        late, of_run = of.record.tau >= _START, of.run
        true = _signals(of_run)
        smooth = passed(of.record, How(INPUTS, None), {}, 1, unseen).outputs
        causal = passed(of.record, How(INPUTS), {}, 1, unseen).outputs
        errors = [_root_mean_square(smooth[hat(name)][late] - true[name][late]) for name in quantities]
        sds = [_root_mean_square(causal[f"{name}_sd"][late]) for name in quantities]
        rows.append([errors, sds])
    coordinates = {"seed": list(seeds), "line": [SMOOTHER, BOUND], "quantity": list(quantities)}
    return xr.DataArray(np.array(rows), coordinates, ("seed", "line", "quantity"))


def _signals(run: xr.Dataset) -> dict[str, np.ndarray]:
    states = {name: run.x.sel(state=name).values for name in run.state.values.tolist()}
    of_muscles = {f"{kind}{j}": run[kind].isel(muscle=j - 1).values for kind in ("u", "a") for j in (1, 2)}
    return {**states, **of_muscles, "Delta": run.Delta.values}


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
