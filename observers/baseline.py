"""The trivial baseline that every observer is measured against: raw outputs, a constant, zeros."""

from __future__ import annotations

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.curves import NGUYEN2019, CurveSet, per_muscle
from ..model.symbols import MEASURED, MUSCLES

PARAMETERS = {
    "Delta": Parameter(0.005, "Δ̂: the mean of the uncertainty", "spec §8", shared="uncertainty.offset"),
}


def baseline(curves: CurveSet = NGUYEN2019) -> Block:
    """x̂₁ = y₁, x̂₃ = Φ_S⁻¹(y₂), x̂₄ = Φ_S⁻¹(y₃), x̂₂ = û = 0, Δ̂ a constant; no states."""
    u = symbols(MEASURED)
    parameters = {**PARAMETERS, **per_muscle(curves.tendon)}
    p = symbols(parameters)
    L_S1, L_S2 = (curves.Phi_S_inv(u[y], p.part(muscle)) for y, muscle in zip(("y2", "y3"), MUSCLES, strict=True))
    zero = ca.SX(0)
    y = Symbols(x1_hat=u.y1, x2_hat=zero, x3_hat=L_S1, x4_hat=L_S2, Delta_hat=p.Delta, u1_hat=zero, u2_hat=zero)
    return Block("baseline", u=u, p=p, parameters=parameters, y=y)
