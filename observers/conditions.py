"""The theorems' gain conditions, by name: symbolic inequalities, checked with the numbers of a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ..model.block import Symbols

# what the conditions may use beside the observer's parameters, and what it means
FACTS = {
    "h": "integration step",
    "U_m": "bound of |u_j|: the controller's limit, or what the run exceeded it by",
    "sup_dDelta": "largest |Δ̇| between recorded points of the true run",
    "sup_du1": "largest |u̇₁| between recorded points of the true run",
    "sup_du2": "largest |u̇₂| between recorded points of the true run",
}

# the end of RK4's stability interval on the negative axis
RK4_LIMIT = 2.78
# two numbers that are printed equal are equal
_EQUAL = 1e-6


@dataclass(frozen=True)
class Condition:
    """`left relation right`, symbolic in an observer's parameters and the FACTS."""

    name: str
    left: ca.SX
    relation: str
    right: ca.SX


@dataclass(frozen=True)
class Checked:
    """A condition with its two numbers."""

    name: str
    left: float
    relation: str
    right: float
    holds: bool

    def __str__(self) -> str:
        return f"{self.name}: {self.left:.7g} {self.relation} {self.right:.7g} does not hold"


Conditions = Callable[[Symbols, Symbols], list[Condition]]

_HOLDS: Mapping[str, Callable[[float, float], bool]] = {
    ">": lambda left, right: left > right,
    "<": lambda left, right: left < right,
    "=": lambda left, right: abs(left - right) <= _EQUAL * max(abs(left), abs(right)),
}


def above(name: str, left: ca.SX | float, right: ca.SX | float) -> Condition:
    """left > right."""
    return Condition(name, ca.SX(left), ">", ca.SX(right))


def below(name: str, left: ca.SX | float, right: ca.SX | float) -> Condition:
    """left < right."""
    return Condition(name, ca.SX(left), "<", ca.SX(right))


def equal(name: str, left: ca.SX | float, right: ca.SX | float) -> Condition:
    """left = right, to printing accuracy."""
    return Condition(name, ca.SX(left), "=", ca.SX(right))


def positive(name: str, value: ca.SX) -> Condition:
    """value > 0."""
    return above(name, value, 0)


def between(name: str, value: ca.SX, low: ca.SX | float, high: ca.SX | float) -> list[Condition]:
    """low < value < high, as two conditions of one name."""
    return [above(name, value, low), below(name, value, high)]


def check(conditions: list[Condition], symbols: Symbols, values: Mapping[str, float]) -> list[Checked]:
    """Each condition with numbers, `values` for every symbol; one with a number that is not known is left out."""
    sides = ca.vertcat(*(ca.horzcat(c.left, c.right) for c in conditions))
    function = ca.Function("conditions", [symbols.vector()], [sides])
    numbers = np.array(function([values[name] for name in symbols]), dtype=float).reshape(-1, 2)
    return [
        Checked(c.name, left, c.relation, right, bool(_HOLDS[c.relation](left, right)))
        for c, (left, right) in zip(conditions, numbers.tolist(), strict=True)
        if not math.isnan(left + right)
    ]
