"""The trivial baseline that every observer is measured against: raw outputs, a constant, zeros."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.symbols import hat
from ..model.system import PAIR, System

PARAMETERS = {
    "Delta": Parameter(
        0.005, "Δ̂: the mean of the uncertainty", "chosen, docs/observers.md#baseline", shared="uncertainty.offset"
    ),
}


def baseline(system: System = PAIR) -> Block:
    """q̂ = y, L̂_S = Φ_S⁻¹(y), q̇̂ = û = 0, Δ̂ a constant; no states."""
    parameters = PARAMETERS if system.paper else {f"{of}.Delta": _constant(of) for of in system.joints}
    u, p = symbols([*system.joint("y"), *system.muscle("z")]), symbols(parameters)
    known = dict(zip((*system.joint("q"), *system.muscle("L_S")), u.values(), strict=True))
    known |= dict(zip(system.joint("Delta"), p.values(), strict=True))
    y = Symbols({name: known.get(name.removesuffix(hat("")), ca.SX(0)) for name in system.estimates})
    return Block("baseline", u=u, p=p, parameters=parameters, y=y)


def _constant(joint: str) -> Parameter:
    return replace(PARAMETERS["Delta"], shared=f"uncertainty.{joint}.offset", default=0.0)
