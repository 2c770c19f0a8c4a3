"""The boundary layers of both sliding mode observers: how fast they are, how wide for a recording, what they hide.

In a layer of width δ a constant Δ_Φ holds e₁ off zero, and then x̂₂ is wrong by v₁₁ = λ|e₁|^½ sg(e₁), the injection that
balances it; û₁ and û₂ inherit that. The errors e₁, e₃, e₄ are what the estimates of the measured lengths miss. All this
can be low-passed and added to the estimates. The constants and what they were measured on: docs/gains.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.limits import STABLE
from .chained import LACK
from .observer import Sizes

CORRECTION = {
    "tau_c": Parameter(0.1, "time constant of the low pass of the correction", "docs/gains.md", above=0),
}

# largest slope of |e|^½ e/(δ + |e|), times √δ
SLOPE = 0.55

# damping ζ of e₁ inside its layer; bandwidth w there, over 1/ε₁
_ZETA, _BANDWIDTH = 0.5, 1.25
# α₁₁ over D_max: the paper's inequality has a solution above 2.16
_LEVEL = 2.5
# the injections outweigh the bound of u by this factor
_MARGIN = 1.5
# offset of a tendon's layer over its noise; smallest rate there
_OFFSET, _LEAST_RATE = 0.5, 25.0
# most steps from sample to sample that the layers of the tendons may ask for
_MOST_STEPS = 10
# time constant of the single-pole filters of Δ̂, û over ε_L, for the lag of a double pole; least one over T
_FILTER, _FASTEST = 2.0, 0.5
# keeps the rate finite where a tendon's length has no noise
_NO_NOISE = 1e-12


@dataclass(frozen=True)
class Layers:
    """What both observers share for a recording: the layer of e₁, the rate of those of e₃ and e₄, the filters.

    Lengths, forces and times are in the paper's units.
    """

    alpha: float  # α₁₁, or β₀l₀
    delta: float  # width of the layer of e₁
    largest: float  # what the injections into x̂₃, x̂₄ must outweigh
    rate: float  # slope of these injections
    filters: float  # time constant of those of Δ̂, û
    correction: float  # time constant τ_c


def layers(s: Sizes, T: float) -> Layers:
    """The layers that follow from the sizes of a recording with the sampling period T, in τ."""
    w = _BANDWIDTH / s.eps_1
    # in the layer ë₁ + dė₁ + w²e₁ = Δ_Φ; e₁ is noise, and the offset that Δ_Φ leaves
    e1 = math.hypot(s.sigma_1, s.D / w**2)
    # damping ζ at e₁: δ₁ = 2e₁/ζ²;  α₁₁ = w²δ₁, at least 2.5 D_max
    alpha = max(w**2 * 2 * e1 / _ZETA**2, _LEVEL * s.D_max)
    delta = alpha / w**2

    def missed(D: float) -> float:
        """v₁₁ under a constant D: what x̂₂ lacks, and so what the tendons' layers see beside u."""
        # e = δ₁D/(α₁₁ − D),  v₁₁ = λ₁₁√e e/(δ₁ + e)
        e = delta * D / (alpha - D)
        return injection(alpha) * math.sqrt(e) * e / (delta + e)

    sigma_L = max(s.sigma_L, _NO_NOISE)
    # r_L = u/(0.5 σ_L)
    rate = max(math.hypot(s.U, missed(s.D)) / (_OFFSET * sigma_L), _LEAST_RATE)
    return Layers(
        alpha=alpha,
        delta=delta,
        largest=_MARGIN * (s.U_max + missed(s.D_max)),
        rate=min(rate, _MOST_STEPS * STABLE / T),
        filters=max(_FILTER * s.eps_L, _FASTEST * T),
        correction=max(s.eps_1, _FASTEST * T),
    )


def injection(alpha: float) -> float:
    """The λ₁₁ that goes with an α₁₁."""
    # λ₁₁ = √(8α₁₁), as α₀ = 2√(2β₀)
    return math.sqrt(8 * alpha)


def joint_corrected(joint: Block, v11: ca.SX, e1: ca.SX) -> Block:
    """The chain of the mass with corrected outputs; v11 and e1 are expressions in its symbols."""
    x, p = symbols("c_2 c_1"), symbols(CORRECTION)
    # x̂₁ + c₁,  x̂₂ + c₂
    y = {**joint.y, "x1_hat": joint.y.x1_hat + x.c_1, "x2_hat": joint.y.x2_hat + x.c_2, LACK: x.c_2}
    return _low_passed(joint, x, p, {"c_2": v11, "c_1": e1}, y)


def muscle_corrected(muscle: Block, e3: ca.SX) -> Block:
    """The chain of muscle 1 with corrected outputs; e3 is an expression in its symbols."""
    x, p, u = symbols("c_3"), symbols(CORRECTION), symbols(LACK)
    # x̂₃ + c₃,  x̂₄ + c₄,  û₁ − c₂,  û₂ + c₂
    y = {**muscle.y, "x3_hat": muscle.y.x3_hat + x.c_3, "u1_hat": muscle.y.u1_hat - u[LACK]}
    return _low_passed(replace(muscle, u=Symbols({**muscle.u, **u})), x, p, {"c_3": e3}, y)


def _low_passed(block: Block, x: Symbols, p: Symbols, values: Mapping[str, ca.SX], y: Mapping[str, ca.SX]) -> Block:
    # τ_c ċ = −c + (v₁₁, e₁, e₃, e₄)
    dx = {c: (value - x[c]) / p.tau_c for c, value in values.items()}
    return replace(
        block,
        x=Symbols({**block.x, **x}),
        p=Symbols({**block.p, **p}),
        parameters={**block.parameters, **CORRECTION},
        dx=Symbols({**block.dx, **dx}),
        y=Symbols(y),
    )


def correction_rates(p: Symbols) -> Mapping[str, ca.SX]:
    """The rate of the correction's low pass, if these are the parameters of a corrected observer."""
    return {"1/τ_c": 1 / p.tau_c} if "tau_c" in p else {}
