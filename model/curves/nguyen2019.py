"""The curves of the paper, corrected, and with the toe as it is printed.

Nguyen, Warner, La, Mohammadi, Simon and Richter, State Estimation For An Agonistic-Antagonistic Muscle System,
Asian Journal of Control 2019, arXiv:1712.00522: [PhiSj], [PhiPj], [fj], [gj].
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import casadi as ca

from ..block import Parameter, Parameters, Symbols
from ..dialect import clamp
from ..rules import Below
from .curve_set import CurveSet

_PAPER = "paper, "

TENDON: Parameters = {
    "L_slack": Parameter(2.0, "tendon slack length", _PAPER + "[PhiSj]", above=0),
    "toe": Parameter(0.04, "width of the toe region", _PAPER + "[PhiSj]", above=0),
    "F_toe": Parameter(0.5, "tendon force at the end of the toe", _PAPER + "[PhiSj]", above=0),
    "k": Parameter(19.2308, "tendon stiffness beyond the toe; k·toe < 2.5 F_toe", _PAPER + "[PhiSj]", above=0),
}
FIBRE: Parameters = {
    "k_P": Parameter(8.0, "stiffness of the parallel element", _PAPER + "[PhiPj]", least=0),
    "W": Parameter(0.3, "width of the force-length curve", _PAPER + "[fj]", above=0),
    "A_hill": Parameter(0.25, "Hill's constant A", _PAPER + "[gj]", above=0),
    "g_max": Parameter(1.5, "largest force factor while lengthening", _PAPER + "[gj]", above=1),
}

# A₃ = 10F − 4D > 0: the quintic rises on all of (0, 1)
_STEEPEST = 2.5
# below it (0 included) a tendon force is slack: it keeps Φ_S⁻¹ and its derivative finite at 0⁺
_SLACK_FORCE = 1e-45
# from the cube-root seed: three reach the last bit for the paper's tendon, five for every k ≥ 5
_HALLEY_STEPS = 5


def _toe(p: Symbols) -> tuple[ca.SX, ca.SX, ca.SX]:
    """A₃, A₄, A₅ of the C² quintic with Φ = Φ′ = Φ″ = 0 at s = 0 and Φ = F, Φ′ = k, Φ″ = 0 at s = 1."""
    F, D = p.F_toe, p.toe * p.k
    return 10 * F - 4 * D, -15 * F + 7 * D, 6 * F - 3 * D


def _Phi_S(L: ca.SX, p: Symbols) -> ca.SX:
    A3, A4, A5 = _toe(p)
    s = clamp((L - p.L_slack) / p.toe, 0, 1)
    # Φ_S = s³(A₃ + s(A₄ + s A₅)) + k max(L − L_slack − toe, 0)   [PhiSj], corrected
    return s**3 * (A3 + s * (A4 + s * A5)) + p.k * ca.fmax(L - p.L_slack - p.toe, 0)


def _Phi_S_inv(y: ca.SX, p: Symbols) -> ca.SX:
    A3, A4, A5 = _toe(p)
    force = clamp(y, _SLACK_FORCE, p.F_toe)
    # near 0 the quintic is A₃ s³
    s = ca.fmin(1, (force / A3) ** (1 / 3))
    for _ in range(_HALLEY_STEPS):
        q = s**3 * (A3 + s * (A4 + s * A5)) - force
        dq = s**2 * (3 * A3 + s * (4 * A4 + s * 5 * A5))
        ddq = s * (6 * A3 + s * (12 * A4 + s * 20 * A5))
        # s ← s − 2 q q′/(2 q′² − q q″)   Halley
        s = clamp(s - 2 * q * dq / (2 * dq**2 - q * ddq), 0.1 * s, 1)
    return p.L_slack + p.toe * s + ca.fmax(y - p.F_toe, 0) / p.k


# seeds of the quick inverse interpolate here, in √force; below the first they are poor
_SEEDED = tuple(0.6 - 0.4 * math.cos((2 * i + 1) * math.pi / 14) for i in range(7))
# so far from the seed, as a part of it, the series is good to the last bit
_SERIES = 1.5e-3


def _Phi_S_inv_near(ys: Sequence[ca.SX], p: Symbols) -> tuple[list[ca.SX], ca.SX]:
    A3, A4, A5 = _toe(p)
    forces = [clamp(y, 0, p.F_toe) for y in ys]

    # s₀: inverse interpolation of √Φ_S, Newton's form; all but the argument follows from the parameters
    nodes = [ca.sqrt(s**3 * (A3 + s * (A4 + s * A5))) for s in _SEEDED]
    differences = [ca.SX(s) for s in _SEEDED]
    for width in range(1, len(nodes)):
        for i in range(len(nodes) - 1, width - 1, -1):
            differences[i] = (differences[i] - differences[i - 1]) / (nodes[i] - nodes[i - width])
    root = ca.sqrt(forces[0])
    s = differences[-1]
    for node, difference in zip(nodes[-2::-1], differences[-2::-1], strict=True):
        s = s * (root - node) + difference

    # Φ_S = Σ Dᵢ(s − s₀)ⁱ,  cᵢ = Dᵢ/D₁
    D0 = s**3 * (A3 + s * (A4 + s * A5))
    slope = 1 / (s**2 * (3 * A3 + s * (4 * A4 + s * (5 * A5))))
    c2 = s * (3 * A3 + s * (6 * A4 + s * (10 * A5))) * slope
    c3 = (A3 + s * (4 * A4 + s * (10 * A5))) * slope
    c4, c5 = (A4 + s * (5 * A5)) * slope, A5 * slope
    # its inverse series s − s₀ = Σ bᵢwⁱ,  w = (force − D₀)/D₁   (Lagrange)
    square = c2 * c2
    b3 = 2 * square - c3
    b4 = c2 * (5 * c3 - 5 * square) - c4
    b5 = square * (14 * square - 21 * c3) + 6 * c2 * c4 + 3 * c3 * c3 - c5
    results, doubt = [], ca.SX(0)
    for y, force in zip(ys, forces, strict=True):
        w = (force - D0) * slope
        series = s + w * (1 + w * (-c2 + w * (b3 + w * (b4 + w * b5))))
        results.append(p.L_slack + p.toe * series + ca.fmax(y - p.F_toe, 0) / p.k)
        doubt = ca.fmax(doubt, ca.fabs(w))
    # |w| ≤ d min(s, 1/|c₂|, 1/√|c₃|): a curve that is nearly flat bends within less
    bend = ca.fmax(1, s * s * ca.fmax(square, ca.fabs(c3)))
    # also where nothing is a number
    return results, ca.logic_not(doubt * doubt * bend <= (_SERIES * s) ** 2)


def _Phi_P(L_C: ca.SX, p: Symbols) -> ca.SX:
    # Φ_P = 8 max(L_C − 1, 0)³   [PhiPj]
    return p.k_P * ca.fmax(L_C - 1, 0) ** 3


def _f(L_C: ca.SX, p: Symbols) -> ca.SX:
    # f = exp(−((L_C − 1)/W)²)   [fj]
    return ca.exp(-(((L_C - 1) / p.W) ** 2))


def _g_inv(z: ca.SX, p: Symbols) -> ca.SX:
    A, g_max = p.A_hill, p.g_max
    low, high = ca.fmin(z, 1), ca.fmax(z, 1)
    # z ≤ 1: (1 − z)/(1 + z/A);  z > 1: −A(z − 1)(g_max − 1)/((A + 1)(g_max − z)); the other term is 0   [gj]
    return (1 - low) / (1 + low / A) - A * (high - 1) * (g_max - 1) / ((A + 1) * (g_max - high))


def _g(u: ca.SX, p: Symbols) -> ca.SX:
    A, g_max = p.A_hill, p.g_max
    w, v = ca.fmax(u, 0), ca.fmax(-u, 0)
    # u ≥ 0: (1 − u)/(1 + u/A);  v = −u > 0: (v(A+1)g_max + A(g_max−1))/(A(g_max−1) + v(A+1)); the other factor is 1
    return (1 - w) * (v * (A + 1) * g_max + A * (g_max - 1)) / ((1 + w / A) * (A * (g_max - 1) + v * (A + 1)))


_RISES = Below(
    "k·toe",
    f"{_STEEPEST:g} F_toe",
    "or the tendon force does not rise in the toe",
    lambda p: (p.k * p.toe, _STEEPEST * p.F_toe),
)

NGUYEN2019 = CurveSet(
    name="nguyen2019",
    sentence="the paper's curves; the toe is the C² quintic that its rounded decimals stand for",
    source="Nguyen et al., Asian Journal of Control 2019, [PhiSj], [PhiPj], [fj], [gj]; corrected, docs/errata.md",
    tendon=TENDON,
    fibre=FIBRE,
    Phi_S=_Phi_S,
    Phi_S_inv=_Phi_S_inv,
    Phi_P=_Phi_P,
    f=_f,
    g=_g,
    g_inv=_g_inv,
    toe_force=lambda p: p.F_toe,
    Phi_S_inv_near=_Phi_S_inv_near,
    rises=_RISES,
)

# the six decimals of [PhiSj] as printed, highest power first
PRINTED_TOE = ("6760794.14", "-68434261.19", "277072371.99", "-560875494.46", "567666340.97", "-229806913.40")


def _Phi_S_printed(L: ca.SX, p: Symbols) -> ca.SX:
    end = p.L_slack + p.toe
    inside = clamp(L, p.L_slack, end)
    quintic = ca.SX(0)
    for coefficient in PRINTED_TOE:
        quintic = quintic * inside + float(coefficient)
    return (L >= p.L_slack) * (L < end) * quintic + (L >= end) * (p.F_toe + p.k * (L - end))


NGUYEN2019_PRINTED = replace(
    NGUYEN2019,
    name="nguyen2019_printed",
    sentence="the toe with the printed decimals: it jumps at both ends; for the errata study only",
    source="Nguyen et al., arXiv:1712.00522, [PhiSj] as printed",
    Phi_S=_Phi_S_printed,
)
