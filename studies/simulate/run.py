"""One scenario, all observers, one Dataset."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import xarray as xr
from numpy.typing import ArrayLike

from ...codegen.batch import CompiledLoop, Trace, compile_loop
from ..files.progress import Progress, shares, unseen
from ..scenarios.layers import Value
from ..scenarios.observers import Observers
from ..scenarios.prepare import BASELINE, Prepared, prepare
from .dataset import dataset


class RunWarning(UserWarning):
    """A run ended before its time; the Dataset's attribute `failures` says why."""


def simulate(
    source: str | Path = "paper-clean",
    observers: Observers = None,
    changes: Mapping[str, Value] | None = None,
    progress: Progress | None = None,
    corrected: bool = False,
) -> xr.Dataset:
    """Run a scenario and return states, inputs, activations, estimates and measures with named dimensions.

    source: the name of a shipped scenario, or the path of a TOML file.
    observers: names from the registry, or Blocks with an observer's ports; the paper's three by default.
    changes: path → value on top of the scenario, such as {"plant.m": 1.2, "seed": 3}.
    corrected: the sliding mode observers' layers are corrected, as `estimate` does; the paper's are not.
    progress: given the part that is done.
    The Dataset has the dimensions time, state, muscle, sensor, observer, estimator (observers and the baseline)
    and quantity; everything is dimensionless. Failures are in its attributes, the numbers after one are NaN. Beside
    each measure is its `…_step_error`: twice what the same run at half the step changes.
    ScenarioError for a wrong scenario, path, value or observer; BuildError if nothing can be compiled.

    >>> run = hillobs.simulate("paper-clean", ["high_gain"], changes={"high_gain.eps_h": 0.2})
    >>> print(f"{run.rmse.sel(estimator='high_gain', quantity='x2').item():.1e}")
    3.2e-04
    >>> run.x_hat.dims
    ('observer', 'time', 'state')
    """
    return simulate_prepared(prepare(source, observers, changes or {}, corrected=corrected), progress or unseen)


def simulate_prepared(prepared: Prepared, progress: Progress = unseen) -> xr.Dataset:
    """Run what `prepare` has checked."""
    compiled, estimators = compile_loop(prepared.loop), (BASELINE, *prepared.observers)
    once, again = shares(progress, (1, 2))  # half the step takes twice the steps
    traces = recorded(prepared, compiled, estimators, once)
    halved = _scores_at_half_step(prepared, compiled, estimators, again)
    result = dataset(prepared, traces, halved, str(compiled.path.stem))
    if truth := traces["truth"].failure:
        warnings.warn(f"the plant failed at τ = {truth.time:g}; what follows is NaN", RunWarning, stacklevel=3)
    return result


def recorded(
    prepared: Prepared, compiled: CompiledLoop, observers: Sequence[str] = (), progress: Progress = unseen
) -> dict[str, Trace]:
    """What the truth, the sensors and the observers named do in the run of the scenario, by Block."""
    return compiled.run(prepared.grid, prepared.scenario.seed, _parameters(prepared, compiled), observers, progress)


def _scores_at_half_step(
    prepared: Prepared, compiled: CompiledLoop, observers: Sequence[str], progress: Progress
) -> dict[str, dict[str, float]]:
    """The score of each observer in the same run, with the same noise, at half the step."""
    grid, seeds = prepared.grid.halved(), [prepared.scenario.seed]
    outcomes = compiled.batch(grid, seeds, _parameters(prepared, compiled), observers, progress)
    sums = list(prepared.loop.score.x)
    return {name: dict(zip(sums, outcomes[name].sums[0].tolist(), strict=True)) for name in observers}


def _parameters(prepared: Prepared, compiled: CompiledLoop) -> dict[str, ArrayLike]:
    return {block.name: prepared.paths.values(block, prepared.scenario.given) for block in compiled.loop.blocks}
