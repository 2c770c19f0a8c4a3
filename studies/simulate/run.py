"""One scenario, all observers, one Dataset."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import xarray as xr

from ...codegen.batch import CompiledLoop, Trace, compile_loop
from ...model.block import Block
from ..files.progress import Progress, unseen
from ..scenarios.layers import Value
from ..scenarios.prepare import BASELINE, Prepared, prepare
from .dataset import dataset


class RunWarning(UserWarning):
    """A run ended before its time; the Dataset's attribute `failures` says why."""


def simulate(
    source: str | Path = "paper-clean",
    observers: Sequence[str | Block] | str | Block | None = None,
    changes: Mapping[str, Value] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Run a scenario and return states, inputs, activations, estimates and measures with named dimensions.

    source: the name of a shipped scenario, or the path of a TOML file.
    observers: names from the registry, or Blocks with an observer's ports; all registered ones by default.
    changes: path → value on top of the scenario, such as {"plant.m": 1.2, "seed": 3}.
    The Dataset has the dimensions time, state, muscle, sensor, observer, estimator (observers and the baseline)
    and quantity; everything is dimensionless. Failures are in its attributes, the numbers after one are NaN.
    ScenarioError for a wrong scenario, path, value or observer; BuildError if nothing can be compiled.
    """
    return simulate_prepared(prepare(source, observers, changes or {}), progress or unseen)


def simulate_prepared(prepared: Prepared, progress: Progress = unseen) -> xr.Dataset:
    """Run what `prepare` has checked."""
    compiled = compile_loop(prepared.loop)
    traces = recorded(prepared, compiled, (BASELINE, *prepared.observers), progress)
    result = dataset(prepared, traces, str(compiled.path.stem))
    if truth := traces["truth"].failure:
        warnings.warn(f"the plant failed at τ = {truth.time:g}; what follows is NaN", RunWarning, stacklevel=3)
    return result


def recorded(
    prepared: Prepared, compiled: CompiledLoop, observers: Sequence[str] = (), progress: Progress = unseen
) -> dict[str, Trace]:
    """What the truth, the sensors and the observers named do in the run of the scenario, by Block."""
    scenario = prepared.scenario
    parameters = {block.name: prepared.paths.values(block, scenario.given) for block in prepared.loop.blocks}
    return compiled.run(prepared.grid, scenario.seed, parameters, observers, progress)
