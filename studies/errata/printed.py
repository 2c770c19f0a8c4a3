"""The printed forms, each correction a 0/1 parameter: the only second copy of equations (docs/errata.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import casadi as ca

from ...model.block import Block, Parameter, Symbols, symbols
from ...model.control.backstepping import PARAMETERS, distribute, riccati
from ...model.curves import NGUYEN2019, PRINTED_TOE, CurveSet
from ...model.dialect import clamp, sg
from ...model.symbols import MUSCLES
from ...model.system import pair_system
from ...observers.adaptive_sliding_mode import ADAPTIVE_SLIDING_MODE


@dataclass(frozen=True)
class Erratum:
    """One printed term: its label in the paper, what is printed there and what it must be."""

    where: str
    printed: str
    correct: str


CONTROLLER = {
    "C1": Erratum("ζ", "ζ = … − m ṙ", "− m r̈: only then ė = Ae + Bζ"),
    "C2": Erratum("ẇ, [kappa], β", "β = … + m r̈", "+ m r‴, the derivative of m r̈"),
    "C3": Erratum("[kappa], β", "β = … − (Φ′_S1 + Φ′_S2) x₂", "+ (Φ′_S1 + Φ′_S2) x₂: ẋ₃ = x₂ + u₁, ẋ₄ = −x₂ + u₂"),
    "C4": Erratum("β", "β without Δ̇_Φ", "β = … − m Δ̇_Φ"),
}
OBSERVER = {
    "O2": Erratum("[AO1b]", "x̂̇₂ = β_a sign(e₁)", "+ (y₃ − y₂)/m"),
    "O3": Erratum("[AO1c]", "τ_a Δ̂̇ = −Δ̂ − β_a sign(e₁)", "+ β_a sign(e₁)"),
    "O4": Erratum("[AO2a], [AO3a]", "x̂̇₃, x̂̇₄ without x̂₂", "+ x̂₂ in x̂̇₃, − x̂₂ in x̂̇₄"),
    "O5": Erratum("[AO2b], [AO3b]", "τ_a û̇_j = −û_j − (k_j + η_j) sign(·)", "+ (k_j + η_j) sign(·)"),
    "O8": Erratum("[dotla]", "l̇_a = −ρ_a0 sign(δ_a), δ_a = 0.01 > 0 a constant", "sign(δ_a0)"),
}
ADAPTIVE = "adaptive_as_printed"


def _switches(errata: Mapping[str, Erratum]) -> dict[str, Parameter]:
    return {
        name: Parameter(1.0, f"1: {erratum.correct}; 0: {erratum.printed}, as printed", "docs/errata.md")
        for name, erratum in errata.items()
    }


def backstepping_as_printed(curves: CurveSet = NGUYEN2019) -> Block:
    """The controller with the ports of `backstepping()`; C1…C4 are 1 for the corrected term, 0 for the printed."""
    u = symbols("x1 x2 x3 x4 r dr ddr dddr Delta dDelta")
    parameters = {**PARAMETERS, **pair_system(curves).tendon_parameters, **_switches(CONTROLLER)}
    p = symbols(parameters)
    m = p.m
    Phi_S1, Phi_S2 = (curves.Phi_S(x, p.part(name)) for x, name in zip((u.x3, u.x4), MUSCLES, strict=True))
    slope1, slope2 = ca.jacobian(Phi_S1, u.x3), ca.jacobian(Phi_S2, u.x4)
    e = ca.vertcat(u.x1 - u.r, u.x2 - u.dr)
    A, B = ca.SX([[0, 1], [0, 0]]), ca.vertcat(0, 1 / m)
    K, P = riccati(p)

    # ζ = Φ_S2 − Φ_S1 + mΔ_Φ − m ṙ   printed;  − m r̈   C1
    zeta = Phi_S2 - Phi_S1 + m * u.Delta - m * _either(p.C1, u.ddr, u.dr)
    # K₁ = γ + K B,  K₂ = K A + γ K + BᵀP
    K1, K2 = p.gamma + K @ B, K @ A + p.gamma * K + B.T @ P
    # β = −K₁ζ − K₂e − (Φ′_S2 + Φ′_S1) x₂ + m r̈   printed;  + (…) x₂ C3,  − mΔ̇_Φ C4,  + m r‴ C2
    beta = -K1 * zeta - K2 @ e + _either(p.C3, 1, -1) * (slope1 + slope2) * u.x2
    beta += -p.C4 * m * u.dDelta + m * _either(p.C2, u.dddr, u.ddr)

    # u₁ = −Φ′_S1 β/Δ,  u₂ = Φ′_S2 β/Δ   printed, and right
    limited, guards = distribute(beta, (Phi_S1, Phi_S2), (slope1, slope2), p)
    return Block("controller", u=u, p=p, parameters=parameters, y=Symbols({**limited, "zeta": zeta}), guards=guards)


def adaptive_as_printed() -> Block:
    """The adaptive observer; O2…O5 and O8 are 1 for the corrected term, 0 for the printed."""
    right = ADAPTIVE_SLIDING_MODE.block()
    x, u = right.x, right.u
    p = Symbols({**right.p, **symbols(OBSERVER)})
    e1, e3, e4 = u.y1 - x.x1_hat, u.L_S1 - x.x3_hat, u.L_S2 - x.x4_hat
    L = ca.fmax(p.l0 + x.l_a, p.L_min)
    v1 = p.beta0 * L * sg(e1, p.delta_1)
    v3 = (clamp(x.k_1, 0, p.k_max) + p.eta1) * sg(e3, p.delta_L)
    v4 = (clamp(x.k_2, 0, p.k_max) + p.eta2) * sg(e4, p.delta_L)
    # l̇_a = −ρ_a0 sign(δ_a)   [dotla] printed, δ_a the boundary layer's width;  sign(δ_a0) O8
    fall = -(p.r00 + x.r_a0) * sg(p.delta_a, p.delta_a) * (p.l0 + x.l_a > p.L_min)
    dl_a = _either(p.O8, right.dx.l_a, fall)
    changed = Symbols(
        # x̂̇₁ = x̂₂ + α_a|e₁|^½ sign(e₁) − φ,  φ = −(l̇_a/L_a) e₁   [AO1a] is right, but l̇_a may not be
        x1_hat=right.dx.x1_hat + (dl_a - right.dx.l_a) / L * e1,
        # x̂̇₂ = β_a sign(e₁)   [AO1b] printed;  + (y₃ − y₂)/m O2
        x2_hat=v1 + p.O2 * (u.y3 - u.y2) / p.m,
        # Δ̂̇ = (−Δ̂ − β_a sign(e₁)) / τ_a   [AO1c] printed;  + O3
        Delta_hat=(-x.Delta_hat + _either(p.O3, 1, -1) * v1) / p.tau_a,
        # x̂̇₃ = (k₁ + η₁) sign(e₃)   [AO2a] printed;  + x̂₂ O4
        x3_hat=v3 + p.O4 * x.x2_hat,
        # û̇₁ = (−û₁ − (k₁ + η₁) sign(e₃)) / τ_a   [AO2b] printed;  + O5
        u1_hat=(-x.u1_hat + _either(p.O5, 1, -1) * v3) / p.tau_a,
        # x̂̇₄ = (k₂ + η₂) sign(e₄)   [AO3a] printed;  − x̂₂ O4
        x4_hat=v4 - p.O4 * x.x2_hat,
        # û̇₂ = (−û₂ − (k₂ + η₂) sign(e₄)) / τ_a   [AO3b] printed;  + O5
        u2_hat=(-x.u2_hat + _either(p.O5, 1, -1) * v4) / p.tau_a,
        l_a=dl_a,
    )
    return replace(
        right,
        name=ADAPTIVE,
        p=p,
        parameters={**right.parameters, **_switches(OBSERVER)},
        dx=Symbols({**right.dx, **changed}),
    )


def _either(switch: ca.SX, corrected: ca.SX | float, printed: ca.SX | float) -> ca.SX:
    return switch * corrected + (1 - switch) * printed


def printed_toe(L: Fraction, order: int = 0) -> Fraction:
    """The printed quintic of [PhiSj], or its derivative of the order given, in exact arithmetic."""
    powers = range(len(PRINTED_TOE) - 1, order - 1, -1)
    terms = zip(PRINTED_TOE, powers, strict=False)
    return sum((Fraction(c) * math.perm(n, order) * L ** (n - order) for c, n in terms), Fraction(0))
