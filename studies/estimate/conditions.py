"""The gain conditions of an observer with what the first pass tells of a recording."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from ...model.block import Symbols, symbols
from ...model.system import System
from ...observers import Observer
from ...observers.conditions import FACTS, Checked, Condition, check
from ...observers.observer import Sizes, SystemSizes

# nodes of an expression that are compared
_DEEP = 20


def gain_conditions(
    observer: Observer, system: System, numbers: Mapping[str, float], sizes: SystemSizes, h: float
) -> list[Checked]:
    """What the observer's theorem asks of its `numbers` (name → value); what a recording does not tell is left out.

    The integration needs no check: the steps from sample to sample are chosen by it.
    """
    p, about = symbols(numbers), symbols(FACTS)
    checked: list[Checked] = []
    for of, view in observer.views(system, p).items():
        near = sizes.pair if system.paper else sizes.near(of)
        theorem = observer.theorem(view, about)
        if of:
            # about numbers of this joint or muscle, and not its neighbour's alone
            own = ca.vertcat(*(symbol for name, symbol in p.items() if name.startswith(f"{of}.")))
            theorem = _each_once([c for c in theorem if ca.depends_on(ca.vertcat(c.left, c.right), own)])
        found = check(theorem, Symbols({**p, **about}), {**numbers, **_facts(near, h)})
        checked += [replace(condition, name=f"{of}: {condition.name}") if of else condition for condition in found]
    return checked


def _each_once(conditions: list[Condition]) -> list[Condition]:
    """What is said of both muscles of the pair is said of one."""
    kept: list[Condition] = []
    for condition in conditions:
        sides = ca.vertcat(condition.left, condition.right)
        if not any(ca.is_equal(sides, ca.vertcat(one.left, one.right), _DEEP) for one in kept):
            kept.append(condition)
    return kept


def _facts(sizes: Sizes, h: float) -> dict[str, float]:
    # any p > 0 will do, the smallest asks least; a rate of Δ_Φ or u is not known
    known = {"h": h, "U_m": sizes.U_max, "f_plus": sizes.D_max, "p": 0.0}
    return {**dict.fromkeys(FACTS, math.nan), **known}
