"""The sliding mode observer [SO1a]–[SO3b]: super-twisting on e₁, first order on e₃ and e₄, smoothed sign."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.dialect import root, sg
from ..model.skeleton.load import MASS
from .chained import OF_JOINT, OF_MUSCLE, START, START_OF_JOINT, START_OF_MUSCLE, Chains, chain
from .conditions import Condition, above
from .layers import CORRECTION, SLOPE, correction_rates, injection, joint_corrected, layers, muscle_corrected
from .observer import Observer, Sizes

_PAPER = "paper, §V"

PARAMETERS = {
    "alpha11": Parameter(1.1, "injection of sg(e₁) into x̂₂", _PAPER),
    "lambda11": Parameter(28.17, "injection of |e₁|^½ sg(e₁) into x̂₁", _PAPER),
    "alpha2": Parameter(1.1, "injection of sg(e₃) into x̂₃", _PAPER),
    "alpha3": Parameter(1.0, "injection of sg(e₄) into x̂₄", _PAPER),
    "tau_s": Parameter(0.01, "time constant of the filters that give Δ̂ and û", _PAPER, above=0),
    "delta_s": Parameter(0.01, "boundary layer of the smoothed sign", _PAPER + " [deltas]", least=0),
    "delta_L": Parameter(
        0.01,
        "boundary layer of e₃ and e₄; the paper's is δ_s",
        "docs/gains.md",
        least=0,
        shared="sliding_mode.delta_s",
    ),
    "m": MASS,
    **START,
}
SECOND = {"alpha2": "alpha3", "c_3": "c_4"}


def chains(corrected: bool = False) -> Chains:
    """Their states are the estimates, unless these are `corrected`."""
    return Chains("sliding_mode", joint(corrected), muscle(corrected), {**PARAMETERS, **CORRECTION}, SECOND)


def joint(corrected: bool) -> Block:
    """The chain of the mass."""
    x, u = symbols("x1_hat x2_hat Delta_hat"), symbols(OF_JOINT)
    p = symbols(["alpha11", "lambda11", "tau_s", "delta_s", *START_OF_JOINT])
    # e₁ = y₁ − x̂₁
    e1 = u.y1 - x.x1_hat
    # v₁₁ = λ₁₁|e₁|^½ sg(e₁),  v₁₂ = α₁₁ sg(e₁)   [v11], [v12]
    v11, v12 = p.lambda11 * root(e1) * sg(e1, p.delta_s), p.alpha11 * sg(e1, p.delta_s)
    dx = Symbols(
        # x̂̇₁ = x̂₂ + v₁₁   [SO1a]
        x1_hat=x.x2_hat + v11,
        # x̂̇₂ = (y₃ − y₂)/m + v₁₂   [SO1b]
        x2_hat=u.acc + v12,
        # τ_s Δ̂̇ = −Δ̂ + v₁₂   [SO1c]
        Delta_hat=(-x.Delta_hat + v12) / p.tau_s,
    )
    block = chain("joint", x, u, p, PARAMETERS, dx)
    return joint_corrected(block, v11, e1) if corrected else block


def muscle(corrected: bool) -> Block:
    """The chain of muscle 1."""
    x, u = symbols("x3_hat u1_hat"), symbols(OF_MUSCLE)
    p = symbols(["alpha2", "tau_s", "delta_L", *START_OF_MUSCLE])
    # e₃ = Φ_S⁻¹(y₂) − x̂₃
    e3 = u.L_S1 - x.x3_hat
    # v₂ = α₂ sg(e₃),  v₃ = α₃ sg(e₄)   [v2], [v3]
    v2 = p.alpha2 * sg(e3, p.delta_L)
    dx = Symbols(
        # x̂̇₃ = x̂₂ + v₂,  x̂̇₄ = −x̂₂ + v₃   [SO2a], [SO3a]
        x3_hat=u.rate + v2,
        # τ_s û̇₁ = −û₁ + v₂,  τ_s û̇₂ = −û₂ + v₃   [SO2b], [SO3b]
        u1_hat=(-x.u1_hat + v2) / p.tau_s,
    )
    block = chain("muscle", x, u, p, PARAMETERS, dx)
    return muscle_corrected(block, e3) if corrected else block


def theorem(p: Symbols, facts: Symbols) -> list[Condition]:
    """What theorem [thm_so] asks of the gains."""
    bound = ca.sqrt(2 / (p.alpha11 - facts.f_plus)) * (p.alpha11 + facts.f_plus) * (1 + facts.p) / (1 - facts.p)
    return [
        above("α₁₁ > f⁺ [alpha11]", p.alpha11, facts.f_plus),
        above("λ₁₁ > √(2/(α₁₁ − f⁺)) (α₁₁ + f⁺)(1 + p)/(1 − p) [lambda11]", p.lambda11, bound),
        above("α₂ > U₁ₘ [alpha2]", p.alpha2, facts.U_m),
        above("α₃ > U₂ₘ [alpha3]", p.alpha3, facts.U_m),
    ]


def rates(p: Symbols) -> Mapping[str, ca.SX]:
    """Slopes of v₂, v₃ and v₁₁, bandwidth of e₁ in its layer, the filters."""
    return {
        "α/δ_L": ca.fmax(p.alpha2, p.alpha3) / p.delta_L,
        f"{SLOPE:g} λ₁₁/√δ_s": SLOPE * p.lambda11 / ca.sqrt(p.delta_s),
        "√(α₁₁/δ_s)": ca.sqrt(p.alpha11 / p.delta_s),
        "1/τ_s": 1 / p.tau_s,
        **correction_rates(p),
    }


def gains(s: Sizes, T: float) -> dict[str, float]:
    """The gains for a recording, its layers corrected: docs/gains.md."""
    common = layers(s, T)
    # no smaller than the paper's
    alpha = max(PARAMETERS["alpha2"].default, common.largest)
    return {
        "alpha11": common.alpha,
        "lambda11": injection(common.alpha),
        "alpha2": alpha,
        "alpha3": alpha,
        "tau_s": common.filters,
        "delta_s": common.delta,
        "delta_L": alpha / common.rate,
        "tau_c": common.correction,
    }


TUNED = ("alpha11", "lambda11", "alpha2", "alpha3", "tau_s", "delta_s", "delta_L")
SLIDING_MODE = Observer("SMO", chains, None, theorem, gains, rates, tuned=TUNED)
