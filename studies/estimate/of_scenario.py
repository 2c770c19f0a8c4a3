"""A run of a scenario as a recording of its samples, in the paper's units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from ...model.arrays import Array
from ...model.system import pair_system
from ...observers import OBSERVERS, estimator
from ..files.errors import ScenarioError
from ..files.progress import Progress, unseen
from ..kalman.record import Record
from ..laboratory.laws import Laws
from ..scenarios.layers import Value
from ..scenarios.paths import paths_of
from ..scenarios.prepare import prepare
from ..scenarios.world import PairWorld
from ..simulate.run import simulate_prepared
from .follow import compiled_bank, follower_bank, lengths_block, measured_tendons
from .run import KALMAN
from .sizes.first_pass import first_pass


@dataclass(frozen=True, eq=False)
class Sampled:
    """label: of the scenario; given: its numbers; run: what `simulate` gives, recorded at each sample."""

    label: str
    given: Mapping[str, float]
    run: xr.Dataset
    record: Record


def sampled(source: str | Path, changes: Mapping[str, Value], progress: Progress = unseen) -> Sampled:
    """A scenario of the pair as it is measured: samples are those of its noise. ScenarioError if it has none."""
    usual = prepare(source, None, changes)
    if not (T := usual.value("noise.period")):
        raise ScenarioError("noise.period = 0 takes no samples, and without noise there is nothing to weigh")
    prepared = prepare(source, None, {**changes, "record": T})
    run = simulate_prepared(prepared, progress)
    y = run.y.values
    if not np.isfinite(y).all():
        raise ScenarioError(f"{prepared.label}: the plant fails; there is nothing to be likely")
    world, paths = prepared.scenario.world, prepared.paths
    if not isinstance(world, PairWorld):
        raise ScenarioError(f"{prepared.label} is of a mechanism; densities are found for a pair")
    system, given = pair_system(world.curves), prepared.scenario.given
    compiled = compiled_bank(follower_bank(system, False, ()))
    tendons = lengths_block(compiled.bank)
    z, slopes = measured_tendons(compiled, np.array(paths_of([tendons]).values(tendons, given)), y)
    block = estimator(OBSERVERS[KALMAN].block(), system)
    numbers = dict(zip(block.p, paths.values(block, given), strict=True))
    sizes = first_pass(Laws(system, numbers), y, z, T).pair
    tau: Array = np.arange(float(len(y))) * T
    record = Record(tau, y, z, slopes, np.ones(len(y), dtype=bool), numbers, sizes, T, world.curves)
    return Sampled(usual.label, given, run, record)
