"""The gains of an observer for a recording, from the sizes that its first pass has found.

The rule, its constants and what they were measured on: docs/gains.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ...observers.adaptive_sliding_mode import PARAMETERS as ADAPTIVE
from ..files.errors import ScenarioError
from ..files.quote import shown
from .first_pass import Sizes
from .substeps import STABLE

# damping of e₁ inside its layer; bandwidth there over 1/ε₁
_ZETA, _BANDWIDTH = 0.5, 1.25
# α₁₁ over D_max: the paper's inequality has a solution above 2.16
_LEVEL = 2.5
# margin of what bounds u
_MARGIN = 1.5
# the paper's α₂; no smaller one
_LEAST_ALPHA = 1.1
# offset of a tendon's layer in parts of its noise; smallest rate there
_OFFSET, _LEAST_RATE = 0.5, 25.0
# most substeps that the layers of the tendons may ask for, and those of the adaptive laws
_MOST_STEPS, _ADAPTIVE_STEPS = 10, 2
# the single pole filters of Δ̂, û over ε_L: the lag of the double pole; none faster than this part of T
_FILTER, _FASTEST = 2.0, 0.5
# below it noise of a tendon's length is none
_NO_NOISE = 1e-12
# margin of k₁, k₂; least bound of theirs; bound of the second layers
_EPS_A, _LEAST_K, _R_MAX = 0.3, 0.5, 2.0
# guard L_min, at most this part of l₀; least part of l₀ that is margin
_L_MIN, _L_MIN_PART, _LEAST_MARGIN = 0.05, 0.25, 0.3


def gains(observer: str, sizes: Sizes, T: float) -> dict[str, float]:
    """Path → value of all that the rule says of a registered follower; the rest keeps its defaults.

    Those of the sliding mode observers are for layers that are corrected; without, tau_c has no meaning.
    """
    if observer not in _RULES:
        raise ScenarioError(f"there is no gain rule for {shown(observer)}, only for {', '.join(_RULES)}")
    return {f"{observer}.{name}": value for name, value in _RULES[observer](sizes, T).items()}


@dataclass(frozen=True)
class _Layers:
    """What both sliding mode observers share: the layer of e₁, the rates of those of e₃ and e₄, the filters."""

    alpha: float  # α₁₁, or β₀l₀
    delta: float  # width of the layer of e₁
    largest: float  # what the injections into x̂₃, x̂₄ must outweigh
    rate: float  # slope of these injections
    filters: float
    correction: float


def _layers(s: Sizes, T: float) -> _Layers:
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
        return _lambda(alpha) * math.sqrt(e) * e / (delta + e)

    sigma_L = max(math.sqrt(s.sigma_L1 * s.sigma_L2), _NO_NOISE)
    # r_L = u/(0.5 σ_L)
    rate = max(math.hypot(s.U, missed(s.D)) / (_OFFSET * sigma_L), _LEAST_RATE)
    return _Layers(
        alpha=alpha,
        delta=delta,
        largest=_MARGIN * (s.U_max + missed(s.D_max)),
        rate=min(rate, _MOST_STEPS * STABLE / T),
        filters=max(_FILTER * s.eps_L, _FASTEST * T),
        correction=max(s.eps_1, _FASTEST * T),
    )


def _lambda(alpha: float) -> float:
    # λ₁₁ = √(8α₁₁), as α₀ = 2√(2β₀)
    return math.sqrt(8 * alpha)


def _high_gain(s: Sizes, T: float) -> dict[str, float]:
    return {"eps_h": s.eps_1, "eps_L": s.eps_L}


def _high_gain_3(s: Sizes, T: float) -> dict[str, float]:
    return {"eps_h": s.eps_1, "eps_L": s.eps_L3}


def _sliding_mode(s: Sizes, T: float) -> dict[str, float]:
    layers = _layers(s, T)
    alpha = max(_LEAST_ALPHA, layers.largest)
    return {
        "alpha11": layers.alpha,
        "lambda11": _lambda(layers.alpha),
        "alpha2": alpha,
        "alpha3": alpha,
        "tau_s": layers.filters,
        "delta_s": layers.delta,
        "delta_L": alpha / layers.rate,
        "tau_c": layers.correction,
    }


def _adaptive_sliding_mode(s: Sizes, T: float) -> dict[str, float]:
    layers = _layers(s, T)
    beta0, a_dual, eta, rate = (ADAPTIVE[name].default for name in ("beta0", "a_dual", "eta1", "r01"))
    # β₀L = α₁₁ at L = l₀, where L stays under the disturbance seen: l₀ − |Δ|/(aβ₀) − ε_a0 = 0
    l0 = layers.alpha / beta0
    k_max = max(_LEAST_K, _EPS_A + layers.largest)
    return {
        "l0": l0,
        "eps_a0": max(l0 - s.D / (a_dual * beta0), _LEAST_MARGIN * l0),
        "eps_a1": _EPS_A,
        "eps_a2": _EPS_A,
        "tau_a": layers.filters,
        "delta_a": (rate + _R_MAX) / min(layers.rate, _ADAPTIVE_STEPS * STABLE / T),
        "delta_1": layers.delta,
        "delta_L": (k_max + eta) / layers.rate,
        "L_min": min(_L_MIN, _L_MIN_PART * l0),
        "k_max": k_max,
        "r_max": _R_MAX,
        "tau_c": layers.correction,
    }


_RULES: Mapping[str, Callable[[Sizes, float], dict[str, float]]] = {
    "high_gain": _high_gain,
    "high_gain_3": _high_gain_3,
    "sliding_mode": _sliding_mode,
    "adaptive_sliding_mode": _adaptive_sliding_mode,
}
