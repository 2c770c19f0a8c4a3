"""The controller closed on the estimates: how well the reference is followed by who does not know the states."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ..files.progress import CountedProgress
from ..scenarios.layers import Value
from ..scenarios.world import DELTA, FEEDBACK, STATES
from ..simulate.run import RunWarning, simulate
from .cells import HOME
from .gains import SETS
from .play import entries

# τ from which on a start is forgotten
SETTLED = 8.0


def closed(seeds: Sequence[int], progress: CountedProgress) -> xr.DataArray:
    """(entry, seed) root mean square of x₁ − r from τ = 8 on, with Δ̂ for Δ; the last entry knows states and Δ.

    NaN where the plant fails.
    """
    numbers = {gains.name: gains.numbers(HOME) for gains in SETS}
    corrected = {gains.name: gains.corrected for gains in SETS}
    games = entries()
    rows = {STATES: [_missed("high_gain", {"seed": seed}, False) for seed in seeds]}
    for done, entry in enumerate(games):
        progress(done, len(games))
        changes: dict[str, Value] = {FEEDBACK: entry.observer, DELTA: "estimated", **numbers[entry.gains]}
        rows[str(entry)] = [
            _missed(entry.observer, {**changes, "seed": seed}, corrected[entry.gains]) for seed in seeds
        ]
    return xr.DataArray(np.array(list(rows.values())), {"entry": list(rows), "seed": list(seeds)}, ("entry", "seed"))


def _missed(observer: str, changes: Mapping[str, Value], corrected: bool) -> float:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)  # a failure is NaN in the table
        run = simulate(HOME.source, observer, {**HOME.changes, **changes}, corrected=corrected)
    late = run.sel(time=slice(SETTLED, None))
    return float(np.sqrt(((late.x.sel(state="x1") - late.r) ** 2).mean(skipna=False)))
