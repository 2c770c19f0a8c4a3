"""The backstepping controller, corrected (docs/errata.md C1–C6), with pretension in its null space."""

from __future__ import annotations

import casadi as ca

from ..block import Block, Parameter, Symbols, symbols
from ..curves import NGUYEN2019, Curves, by_muscle
from ..dialect import clamp, outside
from ..skeleton.load import MASS
from ..symbols import MUSCLES
from ..system import pair_system

_PAPER = "paper, §V"

PARAMETERS = {
    "gamma": Parameter(1.0, "rate at which the force error w decays", _PAPER, above=0),
    "q": Parameter(10.0, "weight of the tracking error, Q = q I", _PAPER, above=0),
    "R": Parameter(
        30.0, "weight of the force in the LQR problem behind K and P", "derived, docs/errata.md C7", above=0
    ),
    "k_c": Parameter(0.0, "gain of the pretension; 0 is the paper's law", "chosen, docs/model.md#pretension", least=0),
    "F_c": Parameter(0.2, "mean tendon force that the pretension holds", "chosen, docs/model.md#pretension", least=0),
    "u_max": Parameter(0.9, "limit of |u_j|", "chosen, docs/model.md#limits", above=0, below=1),
    "Delta_min": Parameter(
        0.1, "floor of Φ′²_S1 + Φ′²_S2 when both tendons are slack, or nearly", "chosen, docs/model.md#limits", above=0
    ),
    "m": MASS,
}


def riccati(p: Symbols) -> tuple[ca.SX, ca.SX]:
    """K (1 × 2) and P (2 × 2), the LQR solution for A = [0 1; 0 0], B = [0; 1/m], Q = q I and R."""
    # p₁₂ = m√(qR),  p₂₂ = m√(R(q + 2p₁₂)),  p₁₁ = p₁₂p₂₂/(m²R)
    p12 = p.m * ca.sqrt(p.q * p.R)
    p22 = p.m * ca.sqrt(p.R * (p.q + 2 * p12))
    p11 = p12 * p22 / (p.m**2 * p.R)
    # K = R⁻¹BᵀP
    K = ca.horzcat(p12, p22) / (p.m * p.R)
    return K, ca.vertcat(ca.horzcat(p11, p12), ca.horzcat(p12, p22))


def backstepping(curves: Curves = NGUYEN2019) -> Block:
    """Inputs: the true x1…x4, r, dr, ddr, dddr, Delta, dDelta; outputs u1, u2 and the error force zeta."""
    u = symbols("x1 x2 x3 x4 r dr ddr dddr Delta dDelta")
    parameters = {**PARAMETERS, **pair_system(curves).tendon_parameters}
    p = symbols(parameters)
    m = p.m
    sets = by_muscle(curves)
    Phi_S1, Phi_S2 = (sets[name].Phi_S(x, p.part(name)) for x, name in zip((u.x3, u.x4), MUSCLES, strict=True))
    slope1, slope2 = ca.jacobian(Phi_S1, u.x3), ca.jacobian(Phi_S2, u.x4)

    # step 1: the load.  e = (x₁ − r, x₂ − ṙ),  ė = A e + B ζ
    e = ca.vertcat(u.x1 - u.r, u.x2 - u.dr)
    A, B = ca.SX([[0, 1], [0, 0]]), ca.vertcat(0, 1 / m)
    K, P = riccati(p)
    # ζ = Φ_S2 − Φ_S1 + mΔ_Φ − m r̈
    zeta = Phi_S2 - Phi_S1 + m * u.Delta - m * u.ddr

    # step 2: the force.  w = ζ + K e  →  ẇ = −γ w − BᵀP e
    # K₁ = γ + K B,  K₂ = K A + γ K + BᵀP
    K1, K2 = p.gamma + K @ B, K @ A + p.gamma * K + B.T @ P
    # β = −K₁ζ − K₂e + (Φ′_S1 + Φ′_S2) x₂ − mΔ̇_Φ + m r‴
    beta = -K1 * zeta - K2 @ e + (slope1 + slope2) * u.x2 - m * u.dDelta + m * u.dddr

    u_limited, guards = distribute(beta, (Phi_S1, Phi_S2), (slope1, slope2), p)
    return Block("controller", u=u, p=p, parameters=parameters, y=Symbols({**u_limited, "zeta": zeta}), guards=guards)


def distribute(
    beta: ca.SX, forces: tuple[ca.SX, ca.SX], slopes: tuple[ca.SX, ca.SX], p: Symbols
) -> tuple[Symbols, Symbols]:
    """u1, u2 within their limit, and the guards: the smallest inputs with −Φ′_S1 u₁ + Φ′_S2 u₂ = β, and pretension."""
    # step 3: the muscles.  Δ = Φ′²_S1 + Φ′²_S2
    Delta = slopes[0] ** 2 + slopes[1] ** 2
    floor = ca.fmax(Delta, p.Delta_min)
    # k_c(F_c − (Φ_S1 + Φ_S2)/2)/Δ · (Φ′_S2, Φ′_S1) is in the null space: it moves the mean tension alone
    tension = p.k_c * (p.F_c - (forces[0] + forces[1]) / 2) / floor
    # u₁ = −Φ′_S1 β/Δ + …,  u₂ = Φ′_S2 β/Δ + …
    u1 = -slopes[0] * beta / floor + tension * slopes[1]
    u2 = slopes[1] * beta / floor + tension * slopes[0]
    low, high = -p.u_max, p.u_max
    return (
        Symbols(u1=clamp(u1, low, high), u2=clamp(u2, low, high)),
        Symbols(u1_limit=outside(u1, low, high), u2_limit=outside(u2, low, high), small_slopes=Delta < p.Delta_min),
    )
