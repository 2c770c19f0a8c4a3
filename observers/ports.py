"""What all observers have in common: their ports, their start, their output errors."""

from __future__ import annotations

import casadi as ca

from ..model.block import Parameter, Parameters, Symbols
from ..model.symbols import MEASURED, QUANTITIES, STATES, hat
from .slopes import SLOPES
from .tendons import LENGTHS

# an observer is a Block with (some of) these inputs and all of these outputs
SENSED = (*MEASURED, *LENGTHS)
INPUTS = ("t", *SENSED, *SLOPES)
ESTIMATES = tuple(hat(name) for name in QUANTITIES if name not in ("a1", "a2"))

_START = dict(zip(STATES, (2.62, 0.0, 2.01, 2.01), strict=True))

START: Parameters = {
    f"initial.{hat(x)}": Parameter(
        value, f"estimate of {x} at the start", "chosen, docs/observers.md#start", shared=f"initial.{hat(x)}"
    )
    for x, value in _START.items()
}


def start(p: Symbols) -> Symbols:
    """x̂(0) from the parameters; Δ̂(0) = û(0) = 0."""
    return Symbols({hat(x): p[f"initial.{hat(x)}"] for x in STATES})


def output_errors(x: Symbols, u: Symbols) -> tuple[ca.SX, ca.SX, ca.SX]:
    """e₁, e₃, e₄ of the observer."""
    # e₁ = y₁ − x̂₁,  e₃ = Φ_S⁻¹(y₂) − x̂₃,  e₄ = Φ_S⁻¹(y₃) − x̂₄
    return u.y1 - x.x1_hat, u.L_S1 - x.x3_hat, u.L_S2 - x.x4_hat


def estimates(x: Symbols) -> Symbols:
    """The outputs of an observer whose estimates are states."""
    return Symbols({name: x[name] for name in ESTIMATES})
