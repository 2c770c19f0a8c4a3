"""Levant's robust exact differentiators in the place of the high-gain chains: the larger an error, the slower.

Source: A. Levant, Higher-order sliding modes, differentiation and output-feedback control, Int. J. Control 76 (2003);
the coefficients are those of the non-recursive form.
"""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.skeleton.load import MASS
from .chained import OF_JOINT, OF_MUSCLE, START, START_OF_JOINT, START_OF_MUSCLE, Chains, chain
from .conditions import Condition, above
from .high_gain import LIMIT, multiple_pole
from .observer import Observer, Sizes

_OURS = "chosen, docs/observers.md#levant"

# λ of the chains of order 2 and 1, for x̂₁, x̂₂, Δ̂ and for x̂₃, û₁
_OF_JOINT, _OF_MUSCLE = (2.0, 2.12, 1.1), (1.5, 1.1)
# on a recording the inputs change by their largest value within these times, in τ
_CHANGE_D, _CHANGE_U = 0.1, 0.05

PARAMETERS = {
    "L_D": Parameter(0.056, "Lipschitz constant of Δ_Φ: its largest rate", _OURS, above=0),
    "L_u1": Parameter(0.12, "Lipschitz constant of u₁: its largest rate", _OURS, above=0),
    "L_u2": Parameter(0.12, "Lipschitz constant of u₂: its largest rate", _OURS, above=0),
    "eps_h": Parameter(0.03, "ε of the chain of x̂₁ at e₁ = 0: it is never faster", _OURS, above=0),
    "eps_L": Parameter(0.01, "ε of the chains of x̂₃, x̂₄ at e = 0: they are never faster", _OURS, above=0),
    "m": MASS,
    **START,
}
SECOND = {"L_u1": "L_u2"}


def chains(corrected: bool = False) -> Chains:
    """Their states are the estimates; a layer about e = 0 hides nothing that could be corrected."""
    return Chains("levant", joint(), muscle(), PARAMETERS, SECOND)


def joint() -> Block:
    """The chain of the mass."""
    x, u, p = symbols("x1_hat x2_hat Delta_hat"), symbols(OF_JOINT), symbols(["L_D", "eps_h", *START_OF_JOINT])
    # e₁ = y₁ − x̂₁,  ε = (ε_h³ + |e₁|/L)^⅓
    e1 = u.y1 - x.x1_hat
    eps = (p.eps_h**3 + ca.fabs(e1) / p.L_D) ** (1 / 3)
    first, second, third = _OF_JOINT
    dx = Symbols(
        # x̂̇₁ = x̂₂ + 2/ε e₁,  far from 0  2 L^⅓ |e₁|^⅔ sign(e₁)
        x1_hat=x.x2_hat + first / eps * e1,
        # x̂̇₂ = (y₃ − y₂)/m + Δ̂ + 2.12/ε² e₁,  … L^⅔ |e₁|^⅓ sign(e₁)
        x2_hat=u.acc + x.Delta_hat + second / eps**2 * e1,
        # Δ̂̇ = 1.1/ε³ e₁,  … L sign(e₁)
        Delta_hat=third / eps**3 * e1,
    )
    return chain("joint", x, u, p, PARAMETERS, dx)


def muscle() -> Block:
    """The chain of muscle 1."""
    x, u, p = symbols("x3_hat u1_hat"), symbols(OF_MUSCLE), symbols(["L_u1", "eps_L", *START_OF_MUSCLE])
    # e₃ = Φ_S⁻¹(y₂) − x̂₃,  ε = (ε_L² + |e₃|/L)^½
    e3 = u.L_S1 - x.x3_hat
    eps = ca.sqrt(p.eps_L**2 + ca.fabs(e3) / p.L_u1)
    first, second = _OF_MUSCLE
    dx = Symbols(
        # x̂̇₃ = x̂₂ + û₁ + 1.5/ε e₃,  x̂̇₄ = −x̂₂ + û₂ + 1.5/ε e₄;  far from 0  1.5 L^½ |e₃|^½ sign(e₃)
        x3_hat=u.rate + x.u1_hat + first / eps * e3,
        # û̇₁ = 1.1/ε² e₃,  û̇₂ = 1.1/ε² e₄;  … L sign(e₃)
        u1_hat=second / eps**2 * e3,
    )
    return chain("muscle", x, u, p, PARAMETERS, dx)


def theorem(p: Symbols, facts: Symbols) -> list[Condition]:
    """What makes the estimates exact without noise, the layers aside."""
    return [
        above("L_D > sup|Δ̇|", p.L_D, facts.sup_dDelta),
        above("L_u1 > sup|u̇₁|", p.L_u1, facts.sup_du1),
        above("L_u2 > sup|u̇₂|", p.L_u2, facts.sup_du2),
    ]


def rates(p: Symbols) -> Mapping[str, ca.SX]:
    """The poles of the chains at e = 0, where they are fastest."""
    return {"ρ/ε_h": multiple_pole(_OF_JOINT) / p.eps_h, "ρ/ε_L": multiple_pole(_OF_MUSCLE) / p.eps_L}


def gains(s: Sizes, T: float) -> dict[str, float]:
    """The gains for a recording: docs/gains.md."""
    L_u = s.U_max / _CHANGE_U
    return {"L_D": s.D_max / _CHANGE_D, "L_u1": L_u, "L_u2": L_u, "eps_h": s.eps_1, "eps_L": s.eps_L}


TUNED = ("L_D", "L_u1", "L_u2", "eps_h", "eps_L")
LEVANT = Observer("Levant", chains, None, theorem, gains, rates, LIMIT, tuned=TUNED)
