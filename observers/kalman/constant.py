"""The Kalman filter with the constant gains that it ends with: a linear observer whose two speeds follow from noise.

A chain of n integrators, its last driven by white noise of density s², its first measured every T with noise of the
variance σ²: the steady gains are the coefficients of a Butterworth polynomial of the frequency w = (s/(σ√T))^(1/n).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca

from ...model.block import Block, Parameter, Parameters, Symbols, symbols
from ...model.skeleton.load import MASS
from ...model.symbols import hat
from ..chained import OF_JOINT, OF_MUSCLE, Chains, chain
from ..high_gain import LIMIT
from ..observer import Observer, Sizes
from .parameters import FROM_BOUNDS, INPUTS, NOISE, PAPER_NOISE, TUNED, densities, resolved
from .states import CHAINS, LONGEST

# slope of both tendons at the start of the paper's runs, L_S = 2.018
_SLOPE = 13.5

PARAMETERS: Parameters = {
    "sigma_1": NOISE["sigma_1"],
    **INPUTS,
    "sigma_L": Parameter(
        PAPER_NOISE / _SLOPE, "sd of the tendon lengths that y₂, y₃ tell", f"{FROM_BOUNDS}, over Φ′_S(2.018)", above=0
    ),
    "T": Parameter(0.005, "sampling period", "paper, §V", above=0),
    "m": MASS,
}


def butterworth(n: int) -> list[float]:
    """The coefficients a₁ … a_n of sⁿ + a₁sⁿ⁻¹ + … + a_n, whose roots are n evenly spaced ones on the unit circle."""
    # a_k = Π cos((i − 1)π/2n)/sin(iπ/2n), i = 1 … k
    angle = math.pi / (2 * n)
    ratios = [math.cos((i - 1) * angle) / math.sin(i * angle) for i in range(1, n + 1)]
    return [math.prod(ratios[:k]) for k in range(1, n + 1)]


def chains(corrected: bool = False) -> Chains:
    """Their states are the estimates and the rates of Δ̂ and û; they start at the first sample."""
    joint, muscle = _chain("joint", _OF_MASS, OF_JOINT), _chain("muscle", _OF_MUSCLE_1, OF_MUSCLE)
    return Chains("kalman_constant", joint, muscle, PARAMETERS, SECOND)


@dataclass(frozen=True)
class _Numbers:
    """A chain: its states, how many of them are before the input, and the names of its numbers."""

    states: tuple[str, ...]
    before: int
    measured: str
    sigma: str
    density: str
    order: str


_OF_MASS = _Numbers(("x1", "x2", *CHAINS["Delta"]), 2, "y1", "sigma_1", "s_D", "order_D")
_OF_MUSCLE_1 = _Numbers(("x3", *CHAINS["u1"]), 1, "L_S1", "sigma_L", "s_u1", "order_u")
SECOND = {"s_u1": "s_u2", **{hat(a): hat(b) for a, b in zip(CHAINS["u1"], CHAINS["u2"], strict=True)}}


def _chain(kind: str, of: _Numbers, inputs: Sequence[str]) -> Block:
    x, u, p = symbols(map(hat, of.states)), symbols(inputs), symbols([of.sigma, of.density, of.order, "T"])
    w = _frequency(p, of)
    # x̂̇₁ = x̂₂,  x̂̇₂ = (y₃ − y₂)/m + Δ̂,  Δ̂̇ = d̂,  d̂̇ = …;  x̂̇₃ = x̂₂ + û₁,  x̂̇₄ = −x̂₂ + û₂,  û likewise
    known = {"x2_hat": u.get("acc"), "x3_hat": u.get("rate")}
    dx = Symbols()
    # … + a_i wⁱ e
    error = u[of.measured] - x[hat(of.states[0])]
    for i, (name, after) in enumerate(itertools.pairwise((*x, None)), start=1):
        terms = [term for term in (known.get(name), x[after] if after else None) if term is not None]
        dx[name] = sum(terms, ca.SX(0)) + _coefficient(i, p[of.order], of.before) * w**i * error
    return replace(chain(kind, x, u, p, PARAMETERS, dx), x0=Symbols({hat(of.states[0]): u[of.measured]}))


def _frequency(p: Symbols, of: _Numbers) -> ca.SX:
    # w = (s/(σ√T))^(1/n)
    return (p[of.density] / (p[of.sigma] * ca.sqrt(p.T))) ** (1 / (p[of.order] + of.before))


def _coefficient(i: int, order: ca.SX, before: int) -> ca.SX:
    """a_i of the chain, which begins with `before` states that are no input; 0 beyond its end."""
    polynomials = {k: butterworth(before + k) for k in range(1, LONGEST + 1)}
    return sum((a[i - 1] * (order == k) for k, a in polynomials.items() if i <= len(a)), ca.SX(0))


def rates(p: Symbols) -> Mapping[str, ca.SX]:
    """The poles of the three chains."""
    of_muscle_2 = replace(_OF_MUSCLE_1, density=SECOND["s_u1"])
    numbers = {"w₁": _OF_MASS, "w₃": _OF_MUSCLE_1, "w₄": of_muscle_2}
    return {name: _frequency(p, of) for name, of in numbers.items()}


def gains(s: Sizes, T: float) -> Mapping[str, float]:
    """Noise and densities for a recording: docs/gains.md."""
    known = resolved(s, T)
    return {"sigma_1": known.sigma_1, "sigma_L": known.sigma_L, **densities(known, T), "T": T}


KALMAN_CONSTANT = Observer("KF const", chains, gains=gains, rates=rates, limit=LIMIT, period="T", tuned=TUNED)
