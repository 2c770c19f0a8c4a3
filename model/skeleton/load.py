"""What the muscles pull: a mass on a line, q̈ = (R F)/m + Δ, with L_m = L₀ − Rᵀq."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

import casadi as ca

from ..arrays import Array
from ..block import Parameter

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
