"""The extended high-gain observer [HO1a]–[HO3b]: linear injections, the faster the smaller ε_h."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.skeleton.load import MASS
from .chained import OF_JOINT, OF_MUSCLE, START, START_OF_JOINT, START_OF_MUSCLE, Chains, chain
from .conditions import Condition, above, between, positive
from .observer import Observer, Sizes

_PAPER = "paper, §V"

PARAMETERS = {
    "eps_h": Parameter(0.1, "ε_h: smaller is faster and noisier", _PAPER, above=0),
    "eps_L": Parameter(
        0.1, "ε of the chains of x̂₃, x̂₄; the paper's is ε_h", "docs/gains.md", above=0, shared="high_gain.eps_h"
    ),
    "h11": Parameter(3.0, "injection of e₁ into x̂₁", _PAPER),
    "h12": Parameter(3.0, "injection of e₁ into x̂₂", _PAPER),
    "h13": Parameter(1.0, "injection of e₁ into Δ̂", _PAPER),
    "h21": Parameter(2.0, "injection of e₃ into x̂₃", _PAPER),
    "h22": Parameter(1.0, "injection of e₃ into û₁", _PAPER),
    "h31": Parameter(2.0, "injection of e₄ into x̂₄", _PAPER),
    "h32": Parameter(1.0, "injection of e₄ into û₂", _PAPER),
    "m": MASS,
    **START,
}
_CHAINS = (("h11", "h12", "h13"), ("h21", "h22"), ("h31", "h32"))

SECOND = {"h21": "h31", "h22": "h32"}

# RK4 is stable with longer steps, but near h/ε = 1 its own error shows in noise-free data
LIMIT = 0.75


def chains(corrected: bool = False) -> Chains:
    """Their states are the estimates; there is no layer to correct."""
    return Chains("high_gain", joint(), muscle(), PARAMETERS, SECOND)


def joint() -> Block:
    """The chain of the mass."""
    x, u = symbols("x1_hat x2_hat Delta_hat"), symbols(OF_JOINT)
    p = symbols(["eps_h", "h11", "h12", "h13", *START_OF_JOINT])
    # e₁ = y₁ − x̂₁
    e1, eps = u.y1 - x.x1_hat, p.eps_h
    dx = Symbols(
        # x̂̇₁ = x̂₂ + h₁₁/ε e₁   [HO1a]
        x1_hat=x.x2_hat + p.h11 / eps * e1,
        # x̂̇₂ = (y₃ − y₂)/m + Δ̂ + h₁₂/ε² e₁   [HO1b]
        x2_hat=u.acc + x.Delta_hat + p.h12 / eps**2 * e1,
        # Δ̂̇ = h₁₃/ε³ e₁   [HO1c]
        Delta_hat=p.h13 / eps**3 * e1,
    )
    return chain("joint", x, u, p, PARAMETERS, dx)


def muscle() -> Block:
    """The chain of muscle 1."""
    x, u = symbols("x3_hat u1_hat"), symbols(OF_MUSCLE)
    p = symbols(["eps_L", "h21", "h22", *START_OF_MUSCLE])
    # e₃ = Φ_S⁻¹(y₂) − x̂₃
    e3, eps = u.L_S1 - x.x3_hat, p.eps_L
    dx = Symbols(
        # x̂̇₃ = x̂₂ + û₁ + h₂₁/ε e₃,  x̂̇₄ = −x̂₂ + û₂ + h₃₁/ε e₄   [HO2a], [HO3a]
        x3_hat=u.rate + x.u1_hat + p.h21 / eps * e3,
        # û̇₁ = h₂₂/ε² e₃,  û̇₂ = h₃₂/ε² e₄   [HO2b], [HO3b]
        u1_hat=p.h22 / eps**2 * e3,
    )
    return chain("muscle", x, u, p, PARAMETERS, dx)


def theorem(p: Symbols, facts: Symbols) -> list[Condition]:
    """What theorem [thm_ho] asks of the gains."""
    return [
        *positive_gains(p, *_CHAINS),
        above("s³ + h₁₁s² + h₁₂s + h₁₃ Hurwitz: h₁₁h₁₂ > h₁₃", p.h11 * p.h12, p.h13),
    ]


def positive_gains(p: Symbols, *injections: tuple[str, ...]) -> list[Condition]:
    """What the theorem asks of chains of any order; `injections` are the names of their gains, chain by chain."""
    return [
        *between("0 < ε_h < 1", p.eps_h, 0, 1),
        *(positive(f"{h} > 0", p[h]) for chain in injections for h in chain),
    ]


def rates(p: Symbols) -> Mapping[str, ca.SX]:
    """The poles of the chains."""
    return pole_rates(p, *_CHAINS)


def pole_rates(p: Symbols, *injections: tuple[str, ...]) -> Mapping[str, ca.SX]:
    """ρ/ε of the chain of x̂₁ and of those of x̂₃, x̂₄; `injections` are the names of the gains of these three.

    ρ is 1 if they are binomial, else that of the multiple pole with the largest of their coefficients.
    """
    rho_1, rho_3, rho_4 = (multiple_pole([p[h] for h in chain]) for chain in injections)
    return {"ρ/ε_h": rho_1 / p.eps_h, "ρ/ε_L": ca.fmax(rho_3, rho_4) / p.eps_L}


def multiple_pole(chain: Sequence[ca.SX | float]) -> ca.SX:
    """ρ = maxᵢ (|hᵢ|/C(k, i))^(1/i), since (s + ρ)ᵏ has the coefficients C(k, i) ρⁱ."""
    k = len(chain)
    return functools.reduce(ca.fmax, [(ca.fabs(h) / math.comb(k, i)) ** (1 / i) for i, h in enumerate(chain, 1)])


def gains(s: Sizes, T: float) -> dict[str, float]:
    """The gains for a recording: docs/gains.md."""
    return {"eps_h": s.eps_1, "eps_L": s.eps_L}


# ε_h and ε_L scale these
TUNED = tuple(h for chain in _CHAINS for h in chain)
HIGH_GAIN = Observer("HGO", chains, None, theorem, gains, rates, LIMIT, tuned=TUNED)
