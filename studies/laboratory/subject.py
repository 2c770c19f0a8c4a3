"""Whose recording it is: a pair or a mechanism, with its system, its scales, and what its columns are called."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass

from ...model.arrays import Array
from ...model.system import System, pair_system
from .columns import COLUMNS, Columns
from .laws import Laws
from .muscles import Muscle, MusclePair, muscle_file
from .scales import Scales, scales


@dataclass(frozen=True)
class Bound:
    """What a measured position may be, in its unit, and why."""

    unit: str
    least: float
    most: float
    sentence: str


@dataclass(frozen=True, eq=False)
class Subject:
    """The system in the paper's units and what leads from SI to it and back.

    muscles: by the system's names; labels: what tables call them. columns: of its recordings. positions, forces: name
    of each column that is required → what it may be, in the order of the system's joints and muscles. file: the
    muscle or mechanism file. pair: if it is one.
    """

    system: System
    scales: Scales
    muscles: Mapping[str, Muscle]
    labels: tuple[int | str, ...]
    columns: Columns
    positions: Mapping[str, Bound]
    forces: Mapping[str, Muscle]
    file: Mapping[str, object]
    pair: MusclePair | None = None

    @functools.cached_property
    def laws(self) -> Laws:
        """What the system says of its numbers."""
        numbers = {path.removeprefix("plant."): number for path, number in self.scales.numbers.items()}
        return Laws(self.system, numbers)

    def disturbance(self, q: Array, Delta: Array) -> Array:
        """External forces in N and torques in N m (… × joints), of dimensionless coordinates and accelerations."""
        return self.laws.forces(q, Delta) * self.scales.torques


def pair_subject(pair: MusclePair) -> Subject:
    """A pair. ScenarioError if a muscle 2 of other size has curves that only the reference muscle can have."""
    muscles = (pair.muscle1, pair.muscle2)
    system = pair_system(pair.curves)
    position = Bound("m", 0.0, pair.C, f"the mass is between 0 and C = {pair.C:g} m")
    return Subject(
        system=system,
        scales=scales(pair),
        muscles=dict(zip(system.muscles, muscles, strict=True)),
        labels=(1, 2),
        columns=COLUMNS,
        positions={"position": position},
        forces=dict(zip(("force_1", "force_2"), muscles, strict=True)),
        file=muscle_file(pair),
        pair=pair,
    )
