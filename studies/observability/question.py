"""Which sensors, which unknowns: a question of observability with the numbers of a scenario."""

from __future__ import annotations

import functools
import re
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from ...model.block import Block
from ...model.curves import Curves
from ...model.curves.tendon import Tendon, tendon
from ...model.plant import plant
from ...model.symbols import SIGNALS
from ...model.system import pair_system
from ...observers.observability import (
    augmented,
    observability_matrix,
    structural_rank,
)
from ..files.errors import ScenarioError
from ..files.numbers import whole
from ..files.quote import shown
from ..scenarios.prepare import Prepared


@dataclass(frozen=True)
class Sensor:
    """What a laboratory can measure: an output of the plant, and the half-width of its noise in the paper."""

    output: str
    noise: float
    sentence: str


SENSORS = {
    "x1": Sensor("x1", 1e-3, "position of the mass"),
    "x2": Sensor("x2", 1e-3, "velocity of the mass"),
    "F1": Sensor("Phi_S1", 1e-3, "force of tendon 1"),
    "F2": Sensor("Phi_S2", 1e-3, "force of tendon 2"),
    "L_C1": Sensor("L_C1", 1e-3, "length of fibre 1"),
    "L_C2": Sensor("L_C2", 1e-3, "length of fibre 2"),
}
PAPER_SENSORS = ("x1", "F1", "F2")

UNKNOWNS = {"none": (), "u": ("Delta", "u1", "u2"), "a": ("Delta", "a1", "a2")}

# expressions grow by 1.5 to 3 with each order; a rank that has not grown until then does not
_HIGHEST = 10
# where a scenario has no samples
_PERIOD = 0.005

# `d2u1` is the second derivative of u1
_DERIVATIVE = re.compile(r"^d\d+")


@dataclass(frozen=True, eq=False)
class Question:
    """Which sensors, which unknowns, how many Lie derivatives; `p` are the plant's numbers in a scenario."""

    block: Block
    sensors: tuple[str, ...]
    unknown: str
    order: int
    matrix: ca.Function
    structural_rank: int
    p: tuple[float, ...]
    period: float
    curves: Curves

    @property
    def coordinates(self) -> list[str]:
        """What is to be known: the states, then the unknowns."""
        return list(self.block.x)

    def tendon(self, muscle: str) -> Tendon:
        """The tendon of a muscle."""
        return tendon(self.curves, muscle, dict(zip(self.block.p, self.p, strict=True)))

    @property
    def sizes(self) -> dict[str, float]:
        """The typical size of each coordinate; a derivative's is that of its signal."""
        return {name: SIGNALS[_DERIVATIVE.sub("", name)].size for name in self.coordinates}


def pose(
    prepared: Prepared,
    sensors: Sequence[str] = PAPER_SENSORS,
    unknown: str = "none",
    order: int | None = None,
    derivatives: int = 0,
) -> Question:
    """The question with the scenario's numbers. ScenarioError says what is wrong with it.

    order: highest Lie derivative, n − 1 by default. derivatives: 0 for constant unknowns, else the unknowns are
    signals and their derivatives up to this order are coordinates too.
    """
    if not sensors:
        raise ScenarioError(f"without a sensor nothing can be observed; there are {', '.join(SENSORS)}")
    for name in sensors:
        if name not in SENSORS:
            raise ScenarioError(f"unknown sensor {shown(name)}; there are {', '.join(SENSORS)}")
    if unknown not in UNKNOWNS:
        raise ScenarioError(f"unknown inputs {shown(unknown)}; there are {', '.join(UNKNOWNS)}")
    derivatives = whole("the derivatives of the unknowns", derivatives, 0, _HIGHEST)
    block = _plant(unknown, prepared.scenario.curves, derivatives)
    usual = min(len(block.x) - 1, _HIGHEST)
    order = usual if order is None else whole("the order of the Lie derivatives", order, 0, _HIGHEST)
    outputs = tuple(SENSORS[name].output for name in dict.fromkeys(sensors))
    matrix, rank = _matrix(block, outputs, order)
    period = prepared.value("noise.period") or _PERIOD
    return Question(
        block,
        tuple(dict.fromkeys(sensors)),
        unknown,
        order,
        matrix,
        rank,
        _numbers(block, prepared),
        period,
        prepared.scenario.curves,
    )


@functools.cache
def _plant(unknown: str, curves: Curves, derivatives: int) -> Block:
    return augmented(
        plant(pair_system(curves), "given" if unknown == "a" else "virtual"), UNKNOWNS[unknown], derivatives
    )


@functools.cache
def _matrix(block: Block, outputs: tuple[str, ...], order: int) -> tuple[ca.Function, int]:
    return observability_matrix(block, outputs, order), structural_rank(block, outputs, order)


def _numbers(block: Block, prepared: Prepared) -> tuple[float, ...]:
    """The plant's parameters in the order of `block.p`."""
    known = {f"plant.{name}": name for name in block.p} | {name: name for name in block.p}
    values = {known[path]: prepared.value(path) for path in prepared.paths.parameters if path in known}
    return tuple(values.get(name, block.parameters[name].default) for name in block.p)
