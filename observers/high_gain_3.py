"""The high-gain observer with chains of order 3 for û too, which then follows a ramp without lag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from .chained import Chains
from .conditions import Condition, above
from .high_gain import LIMIT, joint, pole_rates, positive_gains
from .high_gain import PARAMETERS as ORDER_2
from .high_gain import SECOND as OF_ORDER_2
from .high_gain import muscle as order_2
from .observer import Observer, Sizes

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
SECOND = {**OF_ORDER_2, "h23": "h33", "du1_hat": "du2_hat"}


def chains(corrected: bool = False) -> Chains:
    """Their states are the estimates and the rates of û; there is no layer to correct."""
    return Chains("high_gain_3", joint(), muscle(), PARAMETERS, SECOND)


def muscle() -> Block:
    """The chain of muscle 1: that of order 2, whose û has a rate."""
    of_order_2 = order_2()
    x, p = symbols("du1_hat"), symbols("h23")
    # e₃ = Φ_S⁻¹(y₂) − x̂₃
    e3 = of_order_2.u.L_S1 - of_order_2.x.x3_hat
    # û̇₁ = d̂₁ + h₂₂/ε² e₃,  d̂̇₁ = h₂₃/ε³ e₃;  û₂ likewise
    dx = {**of_order_2.dx, "u1_hat": of_order_2.dx.u1_hat + x.du1_hat}
    dx["du1_hat"] = p.h23 / of_order_2.p.eps_L**3 * e3
    return replace(
        of_order_2,
        x=Symbols({**of_order_2.x, **x}),
        p=Symbols({**of_order_2.p, **p}),
        parameters={**of_order_2.parameters, "h23": PARAMETERS["h23"]},
        dx=Symbols(dx),
    )


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


# ε_h and ε_L scale these
TUNED = tuple(h for chain in _CHAINS for h in chain)
HIGH_GAIN_3 = Observer("HGO3", chains, None, theorem, gains, rates, LIMIT, tuned=TUNED)
