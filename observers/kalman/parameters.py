"""The numbers of the Kalman filters: noise, densities and orders, and the rule that finds them for a recording."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from ...model.block import Parameter, Parameters
from ..observer import Sizes
from .states import LONGEST

CHOSEN = "chosen, docs/observers.md#kalman"
# of uniform noise within ±w it is w/√3
PAPER_NOISE, FROM_BOUNDS = 1e-3 / math.sqrt(3), "paper, §V: uniform within ±0.001"

NOISE: Parameters = {
    "sigma_1": Parameter(PAPER_NOISE, "standard deviation of the noise of y₁", FROM_BOUNDS, above=0),
    "sigma_F1": Parameter(PAPER_NOISE, "standard deviation of the noise of y₂", FROM_BOUNDS, above=0),
    "sigma_F2": Parameter(PAPER_NOISE, "standard deviation of the noise of y₃", FROM_BOUNDS, above=0),
}
INPUTS: Parameters = {
    "s_D": Parameter(2.37e-3, "white noise that drives Δ_Φ, √ of its density", CHOSEN, above=0),
    "s_u1": Parameter(4.34e-3, "white noise that drives u₁, √ of its density", CHOSEN, above=0),
    "s_u2": Parameter(4.34e-3, "white noise that drives u₂, √ of its density", CHOSEN, above=0),
    "order_D": Parameter(2, "which derivative of Δ_Φ is the white noise", CHOSEN, least=1, most=LONGEST, whole=True),
    "order_u": Parameter(
        2, "which derivative of u₁ and u₂ is the white noise", CHOSEN, least=1, most=LONGEST, whole=True
    ),
}

# what `tune` changes of the filters: the noise is measured alone, and orders are no gains
TUNED = ("s_D", "s_u1", "s_u2")

# speed w of a chain of order 2, times the ε of the triple pole of high gain that is as noisy
_C1, _CL3 = 0.602, 1.053
# an input changes by its own size within this time, however slow it is
_SLOWEST = 3.0
# noise that is less, over the sampling period, is lost in double precision beside a wrong start
_RESOLUTION = 1e-7
_NOISES = ("sigma_1", "sigma_F1", "sigma_F2", "sigma_L1", "sigma_L2")
# an input is taken to change within this time, in τ, however little the recording tells of it
_LONGEST = 5.0
_USUAL = 2


def resolved(s: Sizes, T: float) -> Sizes:
    """The sizes of a recording, with as much noise as arithmetic needs."""
    return replace(s, **{name: max(getattr(s, name), _RESOLUTION * T) for name in _NOISES})


def densities(s: Sizes, T: float, order_D: int = _USUAL, order_u: int = _USUAL) -> dict[str, float]:
    """√densities with which Δ̂ and û take over as much noise as those of high gain with the ε of the first pass."""
    return _of_speeds(s, T, order_D, order_u, _C1 / s.eps_1, _CL3 / s.eps_L3)


def least_densities(s: Sizes, T: float, order_D: int, order_u: int) -> dict[str, float]:
    """√densities below which an input would not be followed within any time that matters."""
    return _of_speeds(s, T, order_D, order_u, 1 / _LONGEST, 1 / _LONGEST)


def _of_speeds(s: Sizes, T: float, order_D: int, order_u: int, w_1: float, w_L: float) -> dict[str, float]:
    # s = σ√T wⁿ of a chain of n integrators
    s_D = s.sigma_1 * math.sqrt(T) * w_1 ** (order_D + 2)
    s_u = s.sigma_L * math.sqrt(T) * w_L ** (order_u + 1)
    return {"s_D": s_D, "s_u1": s_u, "s_u2": s_u}


def noise(s: Sizes, T: float) -> dict[str, float]:
    """Standard deviations of what is measured."""
    known = resolved(s, T)
    return {name: getattr(known, name) for name in NOISE}


def gains(s: Sizes, T: float) -> Mapping[str, float]:
    """Noise and densities for a recording, from the first pass alone: docs/gains.md."""
    # s ≥ size/θ^(order − ½)
    least = {name: size / _SLOWEST ** (_USUAL - 0.5) for name, size in (("s_D", s.D), ("s_u1", s.U), ("s_u2", s.U))}
    return {**noise(s, T), **{name: max(v, least[name]) for name, v in densities(resolved(s, T), T).items()}}


def frequency(s: float, sigma: float, T: float, n: int | float) -> float:
    """That of a chain of n integrators, w."""
    # w = (s/(σ√T))^(1/n)
    return float((s / (sigma * math.sqrt(T))) ** (1 / n))


def slowest(numbers: Mapping[str, float], sigma_L: float, T: float) -> float:
    """The frequency w of the slowest chain."""
    n = {"s_D": numbers["order_D"] + 2, "s_u1": numbers["order_u"] + 1, "s_u2": numbers["order_u"] + 1}
    sigma = {"s_D": numbers["sigma_1"], "s_u1": sigma_L, "s_u2": sigma_L}
    return min(frequency(numbers[s], sigma[s], T, n[s]) for s in n)
