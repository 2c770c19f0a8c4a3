"""The numbers of the Kalman filters: noise, densities and orders, and the rule that finds them for a recording."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import casadi as ca

from ...model.block import Parameter, Parameters, Symbols
from ..observer import Sizes
from .states import CHAINS, LONGEST

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

# speed w of a chain of order 2, times the ε of the triple pole of high gain that is as noisy
_C1, _CL3 = 0.602, 1.053
# an input changes by its own size within this time, however slow it is
_SLOWEST = 3.0
# noise that is less, over the sampling period, is lost in double precision beside a wrong start
_RESOLUTION = 1e-7
_NOISES = ("sigma_1", "sigma_F1", "sigma_F2", "sigma_L1", "sigma_L2")
# of the chain that each density drives
_ORDERS = {
    name: int(INPUTS[order].default) for name, order in (("s_D", "order_D"), ("s_u1", "order_u"), ("s_u2", "order_u"))
}


def driven(p: Symbols) -> Iterator[tuple[tuple[str, ...], ca.SX, ca.SX]]:
    """Each chain with its order and √density."""
    orders, densities = (p.order_D, p.order_u, p.order_u), (p.s_D, p.s_u1, p.s_u2)
    return zip(CHAINS.values(), orders, densities, strict=True)


def resolved(s: Sizes, T: float) -> Sizes:
    """The sizes of a recording, with as much noise as arithmetic needs."""
    return replace(s, **{name: max(getattr(s, name), _RESOLUTION * T) for name in _NOISES})


def densities(s: Sizes, T: float) -> dict[str, float]:
    """√densities with which Δ̂ and û take over as much noise as those of high gain with the ε of the first pass."""
    # s = σ√T wⁿ,  w = c/ε, of a chain of n integrators
    s_D = s.sigma_1 * math.sqrt(T) * (_C1 / s.eps_1) ** (_ORDERS["s_D"] + 2)
    s_u = s.sigma_L * math.sqrt(T) * (_CL3 / s.eps_L3) ** (_ORDERS["s_u1"] + 1)
    return {"s_D": s_D, "s_u1": s_u, "s_u2": s_u}


def gains(s: Sizes, T: float) -> Mapping[str, float]:
    """Noise and densities for a recording: docs/gains.md."""
    known, sizes = resolved(s, T), {"s_D": s.D, "s_u1": s.U, "s_u2": s.U}
    # s ≥ size/θ^(order − ½)
    least = {name: size / _SLOWEST ** (_ORDERS[name] - 0.5) for name, size in sizes.items()}
    noise = {name: getattr(known, name) for name in NOISE}
    return {**noise, **{name: max(value, least[name]) for name, value in densities(known, T).items()}}
