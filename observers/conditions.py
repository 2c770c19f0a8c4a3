"""The theorems' gain conditions, by name: symbolic inequalities, checked with the numbers of a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..model.arrays import Array
from ..model.block import Symbols

# what the conditions may use beside the observer's parameters, and what it means
FACTS = {
    "h": "integration step",
    "U_m": "bound of |u_j|: the controller's limit, or what the run exceeded it by",
    "f_plus": "bound of |Δ_Φ| that the gains are for: the paper's f⁺",
    "p": "the paper's p of [lambda11]",
    "sup_dDelta": "largest |Δ̇| between recorded points of the true run",
    "sup_du1": "largest |u̇₁| between recorded points of the true run",
    "sup_du2": "largest |u̇₂| between recorded points of the true run",
}

# two numbers that are printed equal are equal
_EQUAL = 1e-6
# nodes of an expression that are compared
_DEEP = 20


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


Truths = NDArray[np.bool_]
Conditions = Callable[[Symbols, Symbols], list[Condition]]

_HOLDS: Mapping[str, Callable[[Array, Array], Truths]] = {
    ">": lambda left, right: left > right,
    "<": lambda left, right: left < right,
    "=": lambda left, right: np.abs(left - right) <= _EQUAL * np.maximum(np.abs(left), np.abs(right)),
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


def each_once(conditions: list[Condition]) -> list[Condition]:
    """What is said of both muscles of the pair is said of one."""
    kept: list[Condition] = []
    for condition in conditions:
        sides = ca.vertcat(condition.left, condition.right)
        if not any(ca.is_equal(sides, ca.vertcat(one.left, one.right), _DEEP) for one in kept):
            kept.append(condition)
    return kept


def check(conditions: list[Condition], symbols: Symbols, values: Mapping[str, float]) -> list[Checked]:
    """Each condition with numbers, `values` for every symbol; one with a number that is not known is left out."""
    left, right = _sides(conditions, symbols, np.array([[values[name]] for name in symbols]))
    return [
        Checked(c.name, float(a[0]), c.relation, float(b[0]), bool(_HOLDS[c.relation](a, b)[0]))
        for c, a, b in zip(conditions, left, right, strict=True)
        if not math.isnan(a[0] + b[0])
    ]


def violated(conditions: list[Condition], symbols: Symbols, values: Array) -> dict[str, Truths]:
    """Name → (points) where the condition does not hold, for `values` (symbols × points); unknown numbers hold."""
    result: dict[str, Truths] = {}
    for c, left, right in zip(conditions, *_sides(conditions, symbols, values), strict=True):
        broken = ~(_HOLDS[c.relation](left, right) | np.isnan(left + right))
        # the two bounds of `between` have one name
        result[c.name] = result.get(c.name, False) | broken
    return result


def _sides(conditions: list[Condition], symbols: Symbols, values: Array) -> tuple[Array, Array]:
    """Left and right (conditions × points) of each condition."""
    sides = [ca.vertcat(ca.SX(0, 1), *side) for side in ([c.left for c in conditions], [c.right for c in conditions])]
    function = ca.Function("conditions", [symbols.vector()], sides)
    shape = len(conditions), values.shape[1]
    left, right = (np.array(side, dtype=float).reshape(shape) for side in function(values))
    return left, right
