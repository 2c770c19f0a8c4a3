"""What the muscles pull: a mass on a line, q̈ = (R F)/m + Δ, with L_m = L₀ − Rᵀq."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

import casadi as ca

from ..arrays import Array
from ..block import Block, Parameter, Symbols, symbols
from ..symbols import MUSCLES

MASS = Parameter(1.0, "mass of the load", "paper, §V", above=0, shared="plant.m")
LENGTH = Parameter(5.54, "L_m1 + L_m2, the distance between the origins", "paper, §V", above=0, shared="plant.C")

# R: muscle 1 pulls the mass to the left, muscle 2 to the right
MOMENT_ARMS = (-1, 1)

# expressions or samples
Q = TypeVar("Q", ca.SX, Array)


def lengths(q: Q, C: Q | float) -> list[Q]:
    """L_m1, L_m2 of the pair at position q [Lmi2]."""
    # L_m = L₀ − Rᵀq,  L₀ = (0, C)
    return [L0 - R * q for L0, R in zip((0.0, C), MOMENT_ARMS, strict=True)]


def pull(F: Iterable[Q]) -> Q:
    """R F: what both tendon forces together do to the mass."""
    first, second = (R * force for R, force in zip(MOMENT_ARMS, F, strict=True))
    return first + second


def mass() -> Block:
    """The load between two muscles. Inputs muscle1_F, muscle2_F, Delta; outputs q, dq and each L_m, dL_m."""
    x = symbols("q dq")
    u = symbols([*(f"{muscle}_F" for muscle in MUSCLES), "Delta"])
    parameters = {
        "m": MASS,
        "C": LENGTH,
        "q0": Parameter(2.6, "position at the start", "chosen, docs/model.md#start"),
        "dq0": Parameter(0.0, "velocity at the start", "chosen, docs/model.md#start"),
    }
    p = symbols(parameters)
    F = [u[f"{muscle}_F"] for muscle in MUSCLES]
    L_m = dict(zip((f"{muscle}_L_m" for muscle in MUSCLES), lengths(x.q, p.C), strict=True))
    dL_m = {f"{muscle}_dL_m": -R * x.dq for R, muscle in zip(MOMENT_ARMS, MUSCLES, strict=True)}
    return Block(
        "mass",
        x=x,
        u=u,
        p=p,
        parameters=parameters,
        # q̇ = q̇,  q̈ = R F/m + Δ   [load1], [load2]
        dx=Symbols(q=x.dq, dq=pull(F) / p.m + u.Delta),
        x0=Symbols(q=p.q0, dq=p.dq0),
        y=Symbols({"q": x.q, "dq": x.dq, **L_m, **dL_m}),
    )
