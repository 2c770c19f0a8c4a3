"""Which sensors, which unknowns: a question of observability with the numbers of a scenario or a mechanism."""

from __future__ import annotations

import dataclasses
import difflib
import functools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from ...model.block import Block
from ...model.curves.tendon import Tendon, tendon
from ...model.plant import plant
from ...model.symbols import SIGNALS
from ...model.system import System
from ...observers.observability import (
    augmented,
    observability_matrix,
    structural_rank,
    with_constants,
)
from ..files.errors import ScenarioError
from ..files.numbers import whole
from ..files.quote import short, shown
from ..laboratory.subject import Subject
from ..scenarios.prepare import Prepared


@dataclass(frozen=True)
class Sensor:
    """What a laboratory can measure: an output of the plant, and the half-width of its noise, the paper's."""

    output: str
    noise: float
    sentence: str


# half-width of the paper's noise, dimensionless; of a mechanism the same
_NOISE = 1e-3
SENSORS = {
    "x1": Sensor("x1", _NOISE, "position of the mass"),
    "x2": Sensor("x2", _NOISE, "velocity of the mass"),
    "F1": Sensor("Phi_S1", _NOISE, "force of tendon 1"),
    "F2": Sensor("Phi_S2", _NOISE, "force of tendon 2"),
    "L_C1": Sensor("L_C1", _NOISE, "length of fibre 1"),
    "L_C2": Sensor("L_C2", _NOISE, "length of fibre 2"),
}
PAPER_SENSORS = ("x1", "F1", "F2")

# what is unknown beside the states: nothing, or Δ with the muscles' inputs
UNKNOWNS = ("none", "u", "a")
# of a mechanism: typical sizes of its signals
_SIZES = {"q": 0.1, "dq": 0.1, "L_S": 0.01, "Delta": 0.1, "u": 0.1, "a": 0.3}
# with more coordinates each order takes three times as long: the fourth seconds, the sixth a minute
_MANY, _ENOUGH = 10, 4
# of a number of a muscle: how far it may be off, as a part of it; of one that is 0 itself
_PART = 0.1
# by Lie derivatives up to this order states and unknown functions are told, if they ever are: position, speed, Δ
_FUNCTIONS = 2

# expressions grow by 1.5 to 3 with each order; a rank that has not grown until then does not
_HIGHEST = 10
# where a scenario has no samples
_PERIOD = 0.005

# `d2u1` is the second derivative of u1
_DERIVATIVE = re.compile(r"^d\d+")


@dataclass(frozen=True, eq=False)
class Question:
    """Which sensors, which unknowns, how many Lie derivatives; `p` are the numbers of the plant.

    available: all sensors that there are. unknowns: the inputs that are not known. numbers: those of muscles that are
    not known either, with their values.
    """

    system: System
    block: Block
    available: Mapping[str, Sensor]
    sensors: tuple[str, ...]
    unknown: str
    unknowns: tuple[str, ...]
    order: int
    matrix: ca.Function
    structural_rank: int
    p: tuple[float, ...]
    numbers: Mapping[str, float]
    period: float
    units: str = ""  # what the numbers of a mechanism are counted in; those of a scenario are dimensionless

    @property
    def outputs(self) -> tuple[str, ...]:
        """What the sensors measure, by the plant's names."""
        return tuple(self.available[name].output for name in self.sensors)

    @property
    def coordinates(self) -> list[str]:
        """What is to be known: the states, then the unknowns, then the numbers."""
        return list(self.block.x)

    def tendon(self, muscle: str) -> Tendon:
        """The tendon of a muscle."""
        return tendon(
            self.system.curves[muscle], muscle, {**dict(zip(self.block.p, self.p, strict=True)), **self.numbers}
        )

    @property
    def sizes(self) -> dict[str, float]:
        """The typical size of each coordinate; a derivative's is that of its signal."""
        return {name: self._size(_DERIVATIVE.sub("", name)) for name in self.coordinates}

    def with_functions(self) -> Question:
        """The same question where the unknowns are any functions of time, not constants."""
        block = _plant(self.system, self.unknown, self.unknowns, _FUNCTIONS - 1, tuple(self.numbers))
        matrix, rank = _matrix(block, self.outputs, _FUNCTIONS)
        return dataclasses.replace(self, block=block, order=_FUNCTIONS, matrix=matrix, structural_rank=rank)

    def _size(self, signal: str) -> float:
        if signal in self.numbers:
            return _PART * (abs(self.numbers[signal]) or 1.0)
        return SIGNALS[signal].size if self.system.paper else _SIZES[signal.rpartition(".")[2]]


def pose(
    prepared: Prepared,
    sensors: Sequence[str] | None = None,
    unknown: str = "none",
    order: int | None = None,
    derivatives: int = 0,
    parameters: Sequence[str] = (),
) -> Question:
    """The question with the scenario's numbers. ScenarioError says what is wrong with it.

    sensors: the paper's by default. order: highest Lie derivative, n − 1 by default. derivatives: 0 for constant
    unknowns, else the unknowns are signals and their derivatives up to this order are coordinates too. parameters:
    muscles, or numbers of them such as muscle1.k, that are not known either; then activations are, unless `unknown`.
    """
    system = prepared.system
    if not system.paper:
        raise ScenarioError(f"{prepared.scenario.name} is of a mechanism; ask about that by its file, --mechanism")
    period = prepared.value("noise.period") or _PERIOD
    given = {path.removeprefix("plant."): prepared.value(path) for path in prepared.paths.parameters}
    chosen = PAPER_SENSORS if sensors is None else sensors
    return _question(system, SENSORS, chosen, unknown, order, derivatives, parameters, given, period)


def pose_mechanism(
    subject: Subject,
    sensors: Sequence[str] | None = None,
    unknown: str = "none",
    order: int | None = None,
    derivatives: int = 0,
    parameters: Sequence[str] = (),
) -> Question:
    """The same of a mechanism; its sensors are joints, muscles (their forces) and fibres, such as BRA.L_C.

    sensors: by default all joints and all muscles.
    """
    system = subject.system
    available = {
        **{joint: Sensor(system.name("q", joint), _NOISE, f"position of {joint}") for joint in system.joints},
        **{muscle: Sensor(system.name("Phi_S", muscle), _NOISE, f"force of {muscle}") for muscle in system.muscles},
        **{name: Sensor(name, _NOISE, f"fibre length {name}") for name in system.muscle("L_C")},
    }

    chosen = [*system.joints, *system.muscles] if sensors is None else sensors
    scales = subject.scales
    period = _PERIOD * scales.rate
    units = f"lengths in {scales.length:.4g} m, forces in {scales.force:.4g} N, times in {1 / scales.rate:.4g} s"
    return _question(system, available, chosen, unknown, order, derivatives, parameters, scales.numbers, period, units)


def _question(
    system: System,
    available: Mapping[str, Sensor],
    sensors: Sequence[str],
    unknown: str,
    order: int | None,
    derivatives: int,
    parameters: Sequence[str],
    given: Mapping[str, float],
    period: float,
    units: str = "",
) -> Question:
    if not sensors:
        raise ScenarioError(f"without a sensor nothing can be observed; there are {', '.join(available)}")
    for name in sensors:
        if name not in available:
            raise ScenarioError(f"unknown sensor {shown(name)}; there are {', '.join(available)}")
    if unknown not in UNKNOWNS:
        raise ScenarioError(f"unknown inputs {shown(unknown)}; there are {', '.join(UNKNOWNS)}")
    derivatives = whole("the derivatives of the unknowns", derivatives, 0, _HIGHEST)
    unknowns = () if unknown == "none" else (*system.joint("Delta"), *system.muscle(unknown))
    numbers = _numbers(system, parameters)
    block = _plant(system, unknown, unknowns, derivatives, numbers)
    usual = min(len(block.x) - 1, _ENOUGH if len(block.x) > _MANY and not system.paper else _HIGHEST)
    if numbers:
        usual = _of_numbers(numbers, unknowns)
    order = usual if order is None else whole("the order of the Lie derivatives", order, 0, _HIGHEST)
    chosen = tuple(dict.fromkeys(sensors))
    matrix, rank = _matrix(block, tuple(available[name].output for name in chosen), order)
    p = numbers_of(block, given)
    values = {name: given.get(name, system.curve_parameters[name].default) for name in numbers}
    return Question(system, block, available, chosen, unknown, unknowns, order, matrix, rank, p, values, period, units)


@functools.cache
def _plant(
    system: System, unknown: str, unknowns: tuple[str, ...], derivatives: int, numbers: tuple[str, ...]
) -> Block:
    # nobody knows u beside numbers that are not known; an activation one may
    drive = "given" if unknown == "a" or (numbers and not unknowns) else "virtual"
    return with_constants(augmented(plant(system, drive), unknowns, derivatives), numbers)


def _numbers(system: System, parameters: Sequence[str]) -> tuple[str, ...]:
    """Those of muscles, and one by one. ScenarioError for what is neither."""
    known = [*system.muscles, *system.curve_parameters]
    if not isinstance(parameters, list | tuple) or not all(isinstance(name, str) for name in parameters):
        raise ScenarioError(f"parameters must be a list of names, not {shown(parameters)}")
    for name in parameters:
        if name not in known:
            near = difflib.get_close_matches(short(name), known, n=3) or list(system.muscles)
            raise ScenarioError(f"unknown number {shown(name)} of a muscle; the nearest are {', '.join(near)}")
    return tuple(path for path in system.curve_parameters if {path, path.partition(".")[0]} & set(parameters))


def _of_numbers(numbers: Sequence[str], unknowns: Sequence[str]) -> int:
    """The order at which a force has told them, if it ever does: each derivative tells one of a muscle's."""
    owners = [name.partition(".")[0] for name in numbers]
    return min(max(map(owners.count, owners)) + bool(unknowns), _HIGHEST)


@functools.cache
def _matrix(block: Block, outputs: tuple[str, ...], order: int) -> tuple[ca.Function, int]:
    return observability_matrix(block, outputs, order), structural_rank(block, outputs, order)


def numbers_of(block: Block, given: Mapping[str, float]) -> tuple[float, ...]:
    """The plant's parameters in the order of `block.p`: those given by name, else their defaults."""
    return tuple(given.get(name, parameter.default) for name, parameter in block.parameters.items())
