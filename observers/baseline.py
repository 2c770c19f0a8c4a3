"""The trivial baseline that every observer is measured against: raw outputs, a constant, zeros."""

from __future__ import annotations

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols

PARAMETERS = {
    "Delta": Parameter(
        0.005, "Δ̂: the mean of the uncertainty", "chosen, docs/observers.md#baseline", shared="uncertainty.offset"
    ),
}


def baseline() -> Block:
    """x̂₁ = y₁, x̂₃ = Φ_S⁻¹(y₂), x̂₄ = Φ_S⁻¹(y₃), x̂₂ = û = 0, Δ̂ a constant; no states."""
    u, p, zero = symbols("y1 L_S1 L_S2"), symbols(PARAMETERS), ca.SX(0)
    y = Symbols(x1_hat=u.y1, x2_hat=zero, x3_hat=u.L_S1, x4_hat=u.L_S2, Delta_hat=p.Delta, u1_hat=zero, u2_hat=zero)
    return Block("baseline", u=u, p=p, parameters=PARAMETERS, y=y)
