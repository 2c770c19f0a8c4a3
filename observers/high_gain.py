"""The extended high-gain observer [HO1a]–[HO3b]: linear injections, the faster the smaller ε_h; û of order 2 or 3."""

from __future__ import annotations

from dataclasses import replace

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.skeleton import MASS
from .conditions import RK4_LIMIT, Condition, above, below, between, positive
from .ports import SENSED, START, estimates, output_errors, start

_PAPER = "paper, §V"
_OURS = "docs/gains.md"
# first index of the gains, index of the error and the length
_CHAINS = ((2, "₃"), (3, "₄"))

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


# with u̇ a state too, û follows a ramp without lag; gains as those of the chain of x̂₁
ORDER_3 = {
    **PARAMETERS,
    "eps_L": replace(PARAMETERS["eps_L"], shared="high_gain_3.eps_h"),
    **{f"h{j}1": Parameter(3.0, f"injection of e{sub} into x̂{sub}", _OURS) for j, sub in _CHAINS},
    **{f"h{j}2": Parameter(3.0, f"injection of e{sub} into û{j - 1}", _OURS) for j, sub in _CHAINS},
    **{f"h{j}3": Parameter(1.0, f"injection of e{sub} into its rate", _OURS) for j, sub in _CHAINS},
}


def high_gain() -> Block:
    """Inputs y1, y2, y3, L_S1, L_S2; seven states, which are the estimates."""
    x = symbols("x1_hat x2_hat Delta_hat x3_hat u1_hat x4_hat u2_hat")
    u, p = symbols(SENSED), symbols(PARAMETERS)
    return Block("high_gain", x=x, u=u, p=p, parameters=PARAMETERS, dx=_rates(x, u, p), x0=start(p), y=estimates(x))


def high_gain_3() -> Block:
    """The same with the rates of û as two further states."""
    x = symbols("x1_hat x2_hat Delta_hat x3_hat u1_hat x4_hat u2_hat du1_hat du2_hat")
    u, p = symbols(SENSED), symbols(ORDER_3)
    _, e3, e4 = output_errors(x, u)
    dx = _rates(x, u, p)
    # û̇₁ = d̂₁ + h₂₂/ε² e₃,  d̂̇₁ = h₂₃/ε³ e₃;  û₂ likewise
    dx |= {"u1_hat": dx.u1_hat + x.du1_hat, "u2_hat": dx.u2_hat + x.du2_hat}
    dx |= {"du1_hat": p.h23 / p.eps_L**3 * e3, "du2_hat": p.h33 / p.eps_L**3 * e4}
    return Block("high_gain_3", x=x, u=u, p=p, parameters=ORDER_3, dx=Symbols(dx), x0=start(p), y=estimates(x))


def _rates(x: Symbols, u: Symbols, p: Symbols) -> Symbols:
    e1, e3, e4 = output_errors(x, u)
    eps, eps_L = p.eps_h, p.eps_L
    return Symbols(
        # x̂̇₁ = x̂₂ + h₁₁/ε e₁   [HO1a]
        x1_hat=x.x2_hat + p.h11 / eps * e1,
        # x̂̇₂ = (y₃ − y₂)/m + Δ̂ + h₁₂/ε² e₁   [HO1b]
        x2_hat=(u.y3 - u.y2) / p.m + x.Delta_hat + p.h12 / eps**2 * e1,
        # Δ̂̇ = h₁₃/ε³ e₁   [HO1c]
        Delta_hat=p.h13 / eps**3 * e1,
        # x̂̇₃ = x̂₂ + û₁ + h₂₁/ε e₃   [HO2a]
        x3_hat=x.x2_hat + x.u1_hat + p.h21 / eps_L * e3,
        # û̇₁ = h₂₂/ε² e₃   [HO2b]
        u1_hat=p.h22 / eps_L**2 * e3,
        # x̂̇₄ = −x̂₂ + û₂ + h₃₁/ε e₄   [HO3a]
        x4_hat=-x.x2_hat + x.u2_hat + p.h31 / eps_L * e4,
        # û̇₂ = h₃₂/ε² e₄   [HO3b]
        u2_hat=p.h32 / eps_L**2 * e4,
    )


def conditions(p: Symbols, facts: Symbols) -> list[Condition]:
    """What theorem [thm_ho] and the integration step ask of the gains."""
    return [
        *between("0 < ε_h < 1", p.eps_h, 0, 1),
        *(positive(f"{h} > 0", p[h]) for h in ("h11", "h12", "h13", "h21", "h22", "h31", "h32")),
        above("s³ + h₁₁s² + h₁₂s + h₁₃ Hurwitz: h₁₁h₁₂ > h₁₃", p.h11 * p.h12, p.h13),
        below("h h₁₁/ε_h < 2.78 (integration)", facts.h * p.h11 / p.eps_h, RK4_LIMIT),
    ]
