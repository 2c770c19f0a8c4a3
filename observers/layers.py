"""What a boundary layer hides from a sliding mode observer, low-passed and added to its estimates.

In a layer of width δ a constant Δ_Φ holds e₁ off zero, and then x̂₂ is wrong by v₁₁ = λ|e₁|^½ sg(e₁), the injection that
balances it; û₁ and û₂ inherit that. The errors e₁, e₃, e₄ are what the estimates of the measured lengths miss.
"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols

CORRECTION = {
    "tau_c": Parameter(0.1, "time constant of the low pass of the correction", "docs/gains.md", above=0),
}


def layers_corrected(block: Block, v11: ca.SX, e1: ca.SX, e3: ca.SX, e4: ca.SX) -> Block:
    """`block` with corrected outputs; v11, e1, e3, e4 are expressions in its symbols."""
    x, p = symbols("c_2 c_1 c_3 c_4"), symbols(CORRECTION)
    # τ_c ċ = −c + (v₁₁, e₁, e₃, e₄)
    dx = {c: (value - x[c]) / p.tau_c for c, value in zip(x, (v11, e1, e3, e4), strict=True)}
    # x̂ + (c₁, c₂, c₃, c₄),  û₁ − c₂,  û₂ + c₂
    change = {"x1_hat": x.c_1, "x2_hat": x.c_2, "x3_hat": x.c_3, "x4_hat": x.c_4, "u1_hat": -x.c_2, "u2_hat": x.c_2}
    y = {name: value + change.get(name, 0) for name, value in block.y.items()}
    return replace(
        block,
        x=Symbols({**block.x, **x}),
        p=Symbols({**block.p, **p}),
        parameters={**block.parameters, **CORRECTION},
        dx=Symbols({**block.dx, **dx}),
        y=Symbols(y),
    )
