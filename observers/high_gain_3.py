"""The high-gain observer with chains of order 3 for û too, which then follows a ramp without lag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from .conditions import Condition, above
from .high_gain import LIMIT, chains, pole_rates, positive_gains
from .high_gain import PARAMETERS as ORDER_2
from .observer import Observer, Sizes
from .ports import SENSED, estimates, output_errors, start

_OURS = "docs/gains.md"
# gains of the three chains; first index of those of û, and the index of their error
_CHAINS = (("h11", "h12", "h13"), ("h21", "h22", "h23"), ("h31", "h32", "h33"))
_OF_U = ((2, "₃"), (3, "₄"))

# all chains have the gains of the chain of x̂₁
PARAMETERS = {
    **ORDER_2,
    "eps_L": replace(ORDER_2["eps_L"], shared="high_gain_3.eps_h"),
    **{f"h{j}1": Parameter(3.0, f"injection of e{sub} into x̂{sub}", _OURS) for j, sub in _OF_U},
    **{f"h{j}2": Parameter(3.0, f"injection of e{sub} into û{j - 1}", _OURS) for j, sub in _OF_U},
    **{f"h{j}3": Parameter(1.0, f"injection of e{sub} into its rate", _OURS) for j, sub in _OF_U},
}


def high_gain_3() -> Block:
    """Inputs y1, y2, y3, L_S1, L_S2; seven estimates and the rates of û."""
    x = symbols("x1_hat x2_hat Delta_hat x3_hat u1_hat x4_hat u2_hat du1_hat du2_hat")
    u, p = symbols(SENSED), symbols(PARAMETERS)
    _, e3, e4 = output_errors(x, u)
    dx = chains(x, u, p)
    # û̇₁ = d̂₁ + h₂₂/ε² e₃,  d̂̇₁ = h₂₃/ε³ e₃;  û₂ likewise
    dx |= {"u1_hat": dx.u1_hat + x.du1_hat, "u2_hat": dx.u2_hat + x.du2_hat}
    dx |= {"du1_hat": p.h23 / p.eps_L**3 * e3, "du2_hat": p.h33 / p.eps_L**3 * e4}
    return Block("high_gain_3", x=x, u=u, p=p, parameters=PARAMETERS, dx=Symbols(dx), x0=start(p), y=estimates(x))


def theorem(p: Symbols, facts: Symbols) -> list[Condition]:
    """What theorem [thm_ho] asks, of chains that are all of order 3."""
    return [
        *positive_gains(p, *_CHAINS),
        *(
            above(f"chain of e{sub} Hurwitz: {h1} {h2} > {h3}", p[h1] * p[h2], p[h3])
            for sub, (h1, h2, h3) in zip("₁₃₄", _CHAINS, strict=True)
        ),
    ]


def rates(p: Symbols) -> Mapping[str, ca.SX]:
    """The poles of the chains."""
    return pole_rates(p, *_CHAINS)


def gains(s: Sizes, T: float) -> dict[str, float]:
    """The gains for a recording: docs/gains.md."""
    return {"eps_h": s.eps_1, "eps_L": s.eps_L3}


HIGH_GAIN_3 = Observer("HGO3", high_gain_3, theorem, gains, rates, LIMIT)
