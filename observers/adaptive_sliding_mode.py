"""The adaptive sliding mode observer [AO1a]–[AO3b], corrected: dual-layer gains that need no bounds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.dialect import clamp, dead_zone, no_higher, no_lower, root, sg
from ..model.limits import STABLE
from ..model.skeleton.load import MASS
from .chained import OF_JOINT, OF_MUSCLE, START, START_OF_JOINT, START_OF_MUSCLE, Chains, chain
from .conditions import Condition, above, between, equal, positive
from .layers import CORRECTION, SLOPE, correction_rates, joint_corrected, layers, muscle_corrected
from .observer import Observer, Sizes

_PAPER, _CHOSEN, _OURS = "paper, §V", "chosen, docs/observers.md#choices-and-guards", "docs/gains.md"
_BETA0 = 1.1
# |d|û|/dτ| ≤ q sup|u̇|
_Q = 1.1

# for recordings: √(L/l₀) of the largest L that the steps allow for
_GROWN = 1.5
# ε_a1 and ε_a2; least k_max; r_max
_EPS_A, _LEAST_K, _R_MAX = 0.3, 0.5, 2.0
# most steps from sample to sample that the adaptive laws may ask for
_MOST_STEPS = 2
# largest L_min over l₀; least ε_a0 over l₀
_L_MIN_PART, _LEAST_MARGIN = 0.25, 0.3

PARAMETERS = {
    "alpha0": Parameter(2 * math.sqrt(2 * _BETA0), "α₀ = 2√(2β₀), printed 2.97", _PAPER),
    "beta0": Parameter(_BETA0, "β₀ > 1", _PAPER),
    "eta1": Parameter(0.2, "what the injection into x̂₃ has beyond k₁", _PAPER),
    "eta2": Parameter(0.2, "what the injection into x̂₄ has beyond k₂", _PAPER),
    "a_dual": Parameter(0.82, "the paper's a: 0 < a < 1/β₀", _PAPER, above=0),
    "l0": Parameter(0.4, "constant part of the gain L", _PAPER, least=0),
    "r00": Parameter(0.4, "constant rate of l_a", _PAPER, least=0),
    "r01": Parameter(0.5, "constant rate of k₁", _PAPER, least=0),
    "r02": Parameter(0.5, "constant rate of k₂", _PAPER, least=0),
    "tau_a": Parameter(0.01, "time constant of the filters that give Δ̂ and û", _PAPER, above=0),
    "eps_a0": Parameter(0.2, "margin of L", _CHOSEN + ": the paper gives no value", least=0),
    "eps_a1": Parameter(0.2, "margin of k₁", _PAPER, least=0),
    "eps_a2": Parameter(0.2, "margin of k₂", _PAPER, least=0),
    "alpha_a1": Parameter(0.99, "part of k₁ that |û₁| may take", _PAPER, above=0),
    "alpha_a2": Parameter(0.99, "part of k₂ that |û₂| may take", _PAPER, above=0),
    "gamma_a0": Parameter(200.0, "growth of r_a0", _PAPER, least=0),
    "gamma_a1": Parameter(300.0, "growth of r_a1", _PAPER, least=0),
    "gamma_a2": Parameter(300.0, "growth of r_a2", _PAPER, least=0),
    "delta00": Parameter(0.001, "dead zone of r_a0", _PAPER, least=0),
    "delta01": Parameter(0.001, "dead zone of r_a1", _PAPER, least=0),
    "delta02": Parameter(0.001, "dead zone of r_a2", _PAPER, least=0),
    "delta_a": Parameter(0.01, "boundary layer of the smoothed sign", _PAPER, least=0),
    "delta_1": Parameter(
        0.01, "boundary layer of e₁; the paper's is δ_a", _OURS, least=0, shared="adaptive_sliding_mode.delta_a"
    ),
    "delta_L": Parameter(
        0.01, "boundary layer of e₃ and e₄; the paper's is δ_a", _OURS, least=0, shared="adaptive_sliding_mode.delta_a"
    ),
    "k_0": Parameter(0.2, "k₁ and k₂ at the start", _CHOSEN, least=0),
    "L_min": Parameter(0.05, "guard: smallest gain L", _CHOSEN, above=0),
    "k_max": Parameter(10.0, "guard: largest gain k_j", _CHOSEN, above=0),
    "r_max": Parameter(20.0, "guard: largest second layer", _CHOSEN, above=0),
    "leak": Parameter(0.0, "leak of the second layers; 5 is better under noise", _CHOSEN, least=0),
    "m": MASS,
    **START,
}
_IN_JOINT = (
    *("alpha0", "beta0", "a_dual", "l0", "r00", "tau_a", "eps_a0", "gamma_a0", "delta00", "delta_a", "delta_1"),
    *("L_min", "r_max", "leak"),
)
_IN_MUSCLE = (
    *("eta1", "r01", "tau_a", "eps_a1", "alpha_a1", "gamma_a1", "delta01", "delta_a", "delta_L", "k_0", "k_max"),
    *("r_max", "leak"),
)
SECOND = {
    **{name: f"{name[:-1]}2" for name in ("eta1", "r01", "eps_a1", "alpha_a1", "gamma_a1", "delta01", "k_1", "r_a1")},
    "c_3": "c_4",
    "k1_limit": "k2_limit",
}


def chains(corrected: bool = False) -> Chains:
    """Their states are the estimates, unless these are `corrected`, and two adaptive ones for each chain."""
    return Chains("adaptive_sliding_mode", joint(corrected), muscle(corrected), {**PARAMETERS, **CORRECTION}, SECOND)


def joint(corrected: bool) -> Block:
    """The chain of the mass."""
    x, u, p = symbols("x1_hat x2_hat Delta_hat l_a r_a0"), symbols(OF_JOINT), symbols([*_IN_JOINT, *START_OF_JOINT])
    # e₁ = y₁ − x̂₁
    e1 = u.y1 - x.x1_hat
    s1 = sg(e1, p.delta_1)
    # first layer of x̂₁, x̂₂.  L = l₀ + l_a,  d₀ = L − |Δ̂|/(aβ₀) − ε_a0   [La], [deltaa0]
    L = p.l0 + x.l_a
    d0 = L - ca.fabs(x.Delta_hat) / (p.a_dual * p.beta0) - p.eps_a0
    # l̇_a = −(r₀₀ + r_a0) sg(d₀)   [dotla], [rhoa0]; a projection at L_min
    rate = -(p.r00 + x.r_a0) * sg(d0, p.delta_a)
    dl_a = no_lower(rate, L, p.L_min)
    # ṙ_a0 = γ_a0|d₀| if |d₀| > δ₀₀ else 0   [dra0]; frozen where the projection holds l_a
    dr_a0 = (dl_a == rate) * _second_layer(x.r_a0, p.gamma_a0 * dead_zone(d0, p.delta00), p)

    guards = Symbols(L_min=L <= p.L_min, r_max=x.r_a0 >= p.r_max)
    # α = α₀√L,  β = β₀L,  φ = −(L̇/L) e₁
    L = ca.fmax(L, p.L_min)
    alpha, beta, phi = p.alpha0 * ca.sqrt(L), p.beta0 * L, -dl_a / L * e1
    v11 = alpha * root(e1) * s1 - phi
    dx = Symbols(
        # x̂̇₁ = x̂₂ + α|e₁|^½ sg(e₁) − φ   [AO1a]
        x1_hat=x.x2_hat + v11,
        # x̂̇₂ = (y₃ − y₂)/m + β sg(e₁)   [AO1b], corrected
        x2_hat=u.acc + beta * s1,
        # τ_a Δ̂̇ = −Δ̂ + β sg(e₁)   [AO1c], corrected
        Delta_hat=(-x.Delta_hat + beta * s1) / p.tau_a,
        l_a=dl_a,
        r_a0=dr_a0,
    )
    block = chain("joint", x, u, p, PARAMETERS, dx, guards=guards)
    return joint_corrected(block, v11, e1) if corrected else block


def muscle(corrected: bool) -> Block:
    """The chain of muscle 1."""
    x, u, p = symbols("x3_hat u1_hat k_1 r_a1"), symbols(OF_MUSCLE), symbols([*_IN_MUSCLE, *START_OF_MUSCLE])
    # e₃ = Φ_S⁻¹(y₂) − x̂₃
    e3 = u.L_S1 - x.x3_hat
    # d_j = k_j − |û_j|/α_aj − ε_aj   has no label, it stands before [uj]
    d = x.k_1 - ca.fabs(x.u1_hat) / p.alpha_a1 - p.eps_a1
    # k̇_j = −(r₀j + r_aj) sg(d_j)   [kj], [rhoaj]; a projection on [0, k_max]
    rate = -(p.r01 + x.r_a1) * sg(d, p.delta_a)
    dk_1 = no_higher(no_lower(rate, x.k_1, 0), x.k_1, p.k_max)
    free = dk_1 == rate
    # ṙ_aj = γ_aj|d_j| if |d_j| > δ₀j else 0   [draj]; frozen where the projection holds k_j
    dr_a1 = free * _second_layer(x.r_a1, p.gamma_a1 * dead_zone(d, p.delta01), p)
    injected = (clamp(x.k_1, 0, p.k_max) + p.eta1) * sg(e3, p.delta_L)
    dx = Symbols(
        # x̂̇₃ = x̂₂ + (k₁ + η₁) sg(e₃),  x̂̇₄ = −x̂₂ + (k₂ + η₂) sg(e₄)   [AO2a], [AO3a], corrected
        x3_hat=u.rate + injected,
        # τ_a û̇₁ = −û₁ + (k₁ + η₁) sg(e₃),  τ_a û̇₂ = −û₂ + (k₂ + η₂) sg(e₄)   [AO2b], [AO3b], corrected
        u1_hat=(-x.u1_hat + injected) / p.tau_a,
        k_1=dk_1,
        r_a1=dr_a1,
    )
    guards = Symbols(k1_limit=1 - free, r_max=x.r_a1 >= p.r_max)
    block = chain("muscle", x, u, p, PARAMETERS, dx, guards=guards)
    block = replace(block, x0=Symbols({**block.x0, "k_1": p.k_0}))
    return muscle_corrected(block, e3) if corrected else block


def _second_layer(r: ca.SX, growth: ca.SX, p: Symbols) -> ca.SX:
    """The rate of a second layer: growth less leak, a projection at r_max."""
    return no_higher(growth - p.leak * r, r, p.r_max)


def theorem(p: Symbols, facts: Symbols) -> list[Condition]:
    """What theorem [thm_ao] and the dual-layer law ask of the gains."""
    positives = ("eta1", "eta2", "l0", "r00", "r01", "r02", "gamma_a0", "gamma_a1", "gamma_a2", "tau_a", "delta_a")
    dead_zones = ("delta00", "delta01", "delta02")
    return [
        above("β₀ > 1", p.beta0, 1),
        equal("α₀ = 2√(2β₀)", p.alpha0, 2 * ca.sqrt(2 * p.beta0)),
        *between("0 < a < 1/β₀", p.a_dual, 0, 1 / p.beta0),
        *(c for j in (1, 2) for c in between(f"0 < α_a{j} < 1", p[f"alpha_a{j}"], 0, 1)),
        *(positive(f"{name} > 0", p[name]) for name in (*positives, *dead_zones, "eps_a0", "eps_a1", "eps_a2")),
        *(
            above(
                f"ε_a{j}²/4 > δ₀{j}² + (q sup|{rate}|/α)²/γ_a{j} (dual layer)",
                p[f"eps_a{j}"] ** 2 / 4,
                p[f"delta0{j}"] ** 2 + (_Q * supremum / alpha) ** 2 / p[f"gamma_a{j}"],
            )
            for j, rate, supremum, alpha in (
                (0, "Δ̇", facts.sup_dDelta, p.a_dual * p.beta0),
                (1, "u̇₁", facts.sup_du1, p.alpha_a1),
                (2, "u̇₂", facts.sup_du2, p.alpha_a2),
            )
        ),
    ]


def rates(p: Symbols) -> Mapping[str, ca.SX]:
    """Slopes of the injections into x̂₃, x̂₄ and x̂₁, bandwidth of e₁ in its layer, the adaptive laws, the filters."""
    return {
        "(k_max + η)/δ_L": (p.k_max + ca.fmax(p.eta1, p.eta2)) / p.delta_L,
        # α₀√L and β₀L, with L grown
        f"{_GROWN:g} · {SLOPE:g} α₀√(l₀/δ₁)": _GROWN * SLOPE * p.alpha0 * ca.sqrt(p.l0 / p.delta_1),
        f"{_GROWN:g} √(β₀l₀/δ₁)": _GROWN * ca.sqrt(p.beta0 * p.l0 / p.delta_1),
        "(r₀ + r_max)/δ_a": (ca.fmax(p.r00, ca.fmax(p.r01, p.r02)) + p.r_max) / p.delta_a,
        "1/τ_a": 1 / p.tau_a,
        **correction_rates(p),
    }


def gains(s: Sizes, T: float) -> dict[str, float]:
    """The gains for a recording, its layers corrected: docs/gains.md."""
    common = layers(s, T)
    beta0, a_dual, eta, r0, L_min = (PARAMETERS[name].default for name in ("beta0", "a_dual", "eta1", "r01", "L_min"))
    # β₀L = α₁₁ at L = l₀, where L stays under the disturbance seen: l₀ − |Δ|/(aβ₀) − ε_a0 = 0
    l0 = common.alpha / beta0
    k_max = max(_LEAST_K, _EPS_A + common.largest)
    return {
        "l0": l0,
        "eps_a0": max(l0 - s.D / (a_dual * beta0), _LEAST_MARGIN * l0),
        "eps_a1": _EPS_A,
        "eps_a2": _EPS_A,
        "tau_a": common.filters,
        "delta_a": (r0 + _R_MAX) / min(common.rate, _MOST_STEPS * STABLE / T),
        "delta_1": common.delta,
        "delta_L": (k_max + eta) / common.rate,
        "L_min": min(L_min, _L_MIN_PART * l0),
        "k_max": k_max,
        "r_max": _R_MAX,
        "tau_c": common.correction,
    }


# α₀ follows from β₀; dead zones and guards stay as they are
TUNED = (
    *("beta0", "eta1", "eta2", "a_dual", "l0", "r00", "r01", "r02", "tau_a", "eps_a0", "eps_a1", "eps_a2"),
    *("alpha_a1", "alpha_a2", "gamma_a0", "gamma_a1", "gamma_a2", "delta_a", "delta_1", "delta_L"),
)
ADAPTIVE_SLIDING_MODE = Observer("ASMO", chains, None, theorem, gains, rates, tuned=TUNED)
