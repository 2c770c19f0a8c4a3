"""Whose recording it is: a pair or a mechanism, with its system, its scales, and what its columns are called."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...model.arrays import Array
from ...model.mechanism import mechanism_system
from ...model.skeleton.tree import PIN
from ...model.system import System, pair_system
from ..files.errors import ScenarioError
from ..files.quote import shown
from ..files.toml import read_toml
from .columns import COLUMNS, Columns
from .laws import Laws
from .mechanisms.mechanism import Mechanism
from .mechanisms.reading import LARGEST_FILE, mechanism_of, read_mechanism
from .mechanisms.writing import mechanism_file
from .muscles import Muscle, MusclePair, muscle_file, muscle_pair, read_muscles
from .scales import Scales, mechanism_scales, scales

# what is measured, and what a recording may know beside it: quantity → what it is, of joints that turn or slide
_OF_JOINT: Mapping[str, tuple[tuple[str, str], tuple[str, str]]] = {
    "position": (("angle", "angle"), ("position", "length")),
    "velocity": (("angular_velocity", "angular velocity"), ("velocity", "velocity")),
    "acceleration": (("angular_acceleration", "angular acceleration"), ("acceleration", "acceleration")),
    "disturbance": (("disturbance", "torque"), ("disturbance", "force")),
}
_OF_MUSCLE: Mapping[str, str] = {
    "force": "force",
    "path_length": "length",
    "tendon_length": "length",
    "fibre_length": "length",
    "fibre_velocity": "velocity",
    "activation": "number",
    "excitation": "number",
}
# what OpenSim calls them, below a coordinate or a muscle
_COORDINATE = {"position": "/value", "velocity": "/speed", "acceleration": "|acceleration"}
_MUSCLE = {
    "force": "|tendon_force",
    "path_length": "|path_length",
    "tendon_length": "|tendon_length",
    "fibre_length": "/fiber_length",
    "fibre_velocity": "|fiber_velocity",
    "activation": "/activation",
    "excitation": "|excitation",
}
# a joint that is farther beyond its range than this part of it is in another unit
_BEYOND = 1.0


@dataclass(frozen=True)
class Bound:
    """What a measured position may be, in its unit, and what to say of what is below or above.

    range: where the paths of the muscles hold.
    """

    unit: str
    least: float
    most: float
    below: str
    above: str
    range: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Subject:
    """The system in the paper's units and what leads from SI to it and back.

    muscles: by the system's names; labels: what tables call them, and joints: the joints, if they need names at all.
    columns: of its recordings. names: quantity → the column of each joint or muscle. positions: required column → what
    it may be. file: the muscle or mechanism file, described: what is in it.
    """

    system: System
    scales: Scales
    muscles: Mapping[str, Muscle]
    labels: tuple[int | str, ...]
    joints: tuple[str, ...]
    columns: Columns
    names: Mapping[str, tuple[str, ...]]
    positions: Mapping[str, Bound]
    file: Mapping[str, object]
    described: MusclePair | Mechanism

    @property
    def pair(self) -> MusclePair | None:
        """The pair, if it is one."""
        return self.described if isinstance(self.described, MusclePair) else None

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism, which it must be."""
        if isinstance(self.described, MusclePair):
            raise ScenarioError("a pair of muscles is no mechanism")
        return self.described

    @functools.cached_property
    def laws(self) -> Laws:
        """What the system says of its numbers."""
        numbers = {path.removeprefix("plant."): number for path, number in self.scales.numbers.items()}
        return Laws(self.system, numbers)

    @property
    def forces(self) -> dict[str, Muscle]:
        """The column of each tendon force → its muscle."""
        return dict(zip(self.names["force"], self.muscles.values(), strict=True))

    @property
    def heights(self) -> Array:
        """Of oblique fibres, in m."""
        # h = l₀ sin α₀
        return np.array([m.optimal_fibre_length * np.sin(m.pennation) for m in self.muscles.values()])

    def fibres(self, q: Array, L_S: Array) -> tuple[Array, Array]:
        """Lengths of fibres in m, of tendons of the lengths L_S, and the cosines of their angles to these."""
        # L_C cos α = L_m − L_S,  L_C sin α = h
        L, heights = self.scales.metres(self.laws.lengths(q) - L_S), self.heights
        oblique = np.hypot(L, heights)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(heights > 0, oblique, L), np.where(heights > 0, L / oblique, 1.0)

    def disturbance(self, q: Array, Delta: Array) -> Array:
        """External forces in N and torques in N m (… × joints), of dimensionless coordinates and accelerations."""
        return self.laws.forces(q, Delta) * self.scales.torques


def subject_of(muscles: str | Path | MusclePair | Mechanism | Subject) -> Subject:
    """The subject of a pair or a mechanism, or of the file of one: a mechanism has joints.

    ScenarioError says what is wrong with it.
    """
    if isinstance(muscles, Subject):
        return muscles
    if not isinstance(muscles, str | Path | MusclePair | Mechanism):
        raise ScenarioError(f"muscles are a file's name or a pair that was read, not {shown(muscles)}")
    if isinstance(muscles, str | Path):
        muscles = read_mechanism(muscles) if is_mechanism(Path(muscles)) else read_muscles(muscles)
    if isinstance(muscles, MusclePair):
        return pair_subject(muscles)
    return _mechanism_subject(json.dumps(mechanism_file(muscles)))


def is_mechanism(path: Path) -> bool:
    """Whether a file of muscles is one of a mechanism. ScenarioError if it cannot be read."""
    return "joints" in read_toml(path, LARGEST_FILE)


def subject_again(content: Mapping[str, object]) -> Subject:
    """The subject whose `file` this is."""
    if "joints" in content:
        return _mechanism_subject(json.dumps(content))
    return pair_subject(muscle_pair(content, None))


def pair_subject(pair: MusclePair) -> Subject:
    """A pair. ScenarioError if a muscle 2 of other size has curves that only the reference muscle can have."""
    system = pair_system(pair.curves)
    between = f"the mass is between 0 and C = {pair.C:g} m"
    position = Bound("m", 0.0, pair.C, between, f"{between}; is it in another unit?")
    of_muscles = [name for name in _OF_MUSCLE if f"{name}_1" in COLUMNS.known]
    return Subject(
        system=system,
        scales=scales(pair),
        muscles=dict(zip(system.muscles, (pair.muscle1, pair.muscle2), strict=True)),
        labels=(1, 2),
        joints=(),
        columns=COLUMNS,
        names={
            **{name: (name,) for name in _OF_JOINT},
            **{name: tuple(f"{name}_{j}" for j in (1, 2)) for name in of_muscles},
        },
        positions={"position": position},
        file=muscle_file(pair),
        described=pair,
    )


# writing down the equation of motion takes a while
@functools.lru_cache(maxsize=8)
def _mechanism_subject(file: str) -> Subject:
    content = json.loads(file)
    mechanism = mechanism_of(content, None)
    s = mechanism_scales(mechanism)
    joints, muscles = mechanism.tree.coordinates, tuple(mechanism.muscles)
    units = dict(zip(joints, s.coordinates.tolist(), strict=True))
    system = mechanism_system(
        mechanism.tree.scaled(s.length, s.mass, s.rate),
        {name: mechanism.paths[name].scaled(s.length, units) for name in muscles},
        {name: muscle.curves for name, muscle in mechanism.muscles.items()},
        frozenset(name for name, muscle in mechanism.muscles.items() if muscle.pennation),
        {name: point.scaled(s.length) for name, point in mechanism.points.items()},
    )
    names, columns = _columns(mechanism)
    return Subject(
        system=system,
        scales=s,
        muscles=mechanism.muscles,
        labels=muscles,
        joints=joints,
        columns=columns,
        names=names,
        positions={column: _bound(mechanism, joint) for joint, column in zip(joints, names["position"], strict=True)},
        file=content,
        described=mechanism,
    )


def _columns(mechanism: Mechanism) -> tuple[dict[str, tuple[str, ...]], Columns]:
    joints, muscles = mechanism.tree.coordinates, tuple(mechanism.muscles)
    known, opensim, theirs = {"time": "time"}, {"time": "time"}, {}
    names: dict[str, tuple[str, ...]] = {}
    for quantity, (turning, sliding) in _OF_JOINT.items():
        kinds = {joint: turning if mechanism.tree.joints[joint].kind == PIN else sliding for joint in joints}
        names[quantity] = tuple(f"{word}_{joint}" for joint, (word, _) in kinds.items())
        known |= {f"{word}_{joint}": measure for joint, (word, measure) in kinds.items()}
        for joint, column in zip(joints, names[quantity], strict=True):
            alias = mechanism.tree.joints[joint].alias or joint
            if below := _COORDINATE.get(quantity):
                opensim[column] = f"/jointset/{mechanism.tree.joints[joint].opensim or joint}/{alias}{below}"
                theirs[re.compile(rf"/jointset/[^/]+/{re.escape(alias)}{re.escape(below)}")] = column
            else:
                opensim[column] = f"/forceset/{column}|actuation"
            if quantity == "position":
                theirs[re.compile(re.escape(alias))] = column
    for quantity, measure in _OF_MUSCLE.items():
        names[quantity] = tuple(f"{quantity}_{muscle}" for muscle in muscles)
        known |= dict.fromkeys(names[quantity], measure)
        opensim |= {f"{quantity}_{muscle}": f"/forceset/{muscle}{_MUSCLE[quantity]}" for muscle in muscles}
    required = (*names["position"], *names["force"])
    known |= {f"{column}_measured": known[column] for column in required}
    return names, Columns(required, known, opensim, theirs)


def _bound(mechanism: Mechanism, name: str) -> Bound:
    """A range is a hint, since a model's paths may go on; far beyond it an angle is in degrees."""
    joint = mechanism.tree.joints[name]
    unit = "rad" if joint.kind == PIN else "m"
    if joint.range is None:
        return Bound(unit, -np.inf, np.inf, "", "")
    least, most = joint.range
    beyond = _BEYOND * (most - least)
    why = f"{name} goes from {least:g} to {most:g} {unit}; is it in {'degrees' if unit == 'rad' else 'another unit'}?"
    return Bound(unit, least - beyond, most + beyond, why, why, joint.range)
