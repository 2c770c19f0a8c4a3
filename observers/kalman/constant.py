"""The Kalman filter with the constant gains that it ends with: a linear observer whose two speeds follow from noise.

A chain of n integrators, its last driven by white noise of density s², its first measured every T with noise of the
variance σ²: the steady gains are the coefficients of a Butterworth polynomial of the frequency w = (s/(σ√T))^(1/n).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import casadi as ca

from ...model.block import Block, Parameter, Parameters, Symbols, symbols
from ...model.skeleton.load import MASS
from ...model.symbols import hat
from ..high_gain import LIMIT
from ..observer import Observer, Sizes
from ..ports import ESTIMATES, SENSED, output_errors
from .parameters import FROM_BOUNDS, INPUTS, NOISE, PAPER_NOISE, densities, driven, resolved
from .states import LONGEST, MEAN

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


def kalman_constant() -> Block:
    """Inputs y1, y2, y3, L_S1, L_S2; 13 states: the estimates and the rates of Δ̂, û₁, û₂."""
    x, u, p = symbols(MEAN), symbols(SENSED), symbols(PARAMETERS)
    dx = Symbols(
        # x̂̇₁ = x̂₂,  x̂̇₂ = (y₃ − y₂)/m + Δ̂
        x1_hat=x.x2_hat,
        x2_hat=(u.y3 - u.y2) / p.m + x.Delta_hat,
        # x̂̇₃ = x̂₂ + û₁,  x̂̇₄ = −x̂₂ + û₂
        x3_hat=x.x2_hat + x.u1_hat,
        x4_hat=-x.x2_hat + x.u2_hat,
    )
    for (before, error), (chain, order, w) in zip(
        zip((("x1", "x2"), ("x3",), ("x4",)), output_errors(x, u), strict=True), speeds(p), strict=True
    ):
        # Δ̂̇ = d̂,  d̂̇ = …;  û likewise
        for name, rate in zip(chain, (*chain[1:], None), strict=True):
            dx[hat(name)] = x[hat(rate)] if rate else ca.SX(0)
        # … + a_i wⁱ e
        for i, name in enumerate((*before, *chain), start=1):
            dx[hat(name)] += _coefficient(i, order, len(before)) * w**i * error
    start = Symbols(x1_hat=u.y1, x3_hat=u.L_S1, x4_hat=u.L_S2)
    return Block(
        "kalman_constant",
        x=x,
        u=u,
        p=p,
        parameters=PARAMETERS,
        dx=dx.only(MEAN),
        x0=start,
        y=x.only(ESTIMATES),
    )


def speeds(p: Symbols) -> list[tuple[tuple[str, ...], ca.SX, ca.SX]]:
    """Each chain of an input with its order and the frequency w of the chain that it ends."""
    result = []
    for (chain, order, s), sigma, before in zip(driven(p), (p.sigma_1, p.sigma_L, p.sigma_L), (2, 1, 1), strict=True):
        # w = (s/(σ√T))^(1/n)
        result.append((chain, order, (s / (sigma * ca.sqrt(p.T))) ** (1 / (order + before))))
    return result


def _coefficient(i: int, order: ca.SX, before: int) -> ca.SX:
    """a_i of the chain, which begins with `before` states that are no input; 0 beyond its end."""
    polynomials = {k: butterworth(before + k) for k in range(1, LONGEST + 1)}
    return sum((a[i - 1] * (order == k) for k, a in polynomials.items() if i <= len(a)), ca.SX(0))


def rates(p: Symbols) -> Mapping[str, ca.SX]:
    """The poles of the three chains."""
    return dict(zip(("w₁", "w₃", "w₄"), (w for _, _, w in speeds(p)), strict=True))


def gains(s: Sizes, T: float) -> Mapping[str, float]:
    """Noise and densities for a recording: docs/gains.md."""
    known = resolved(s, T)
    return {"sigma_1": known.sigma_1, "sigma_L": known.sigma_L, **densities(known, T), "T": T}


KALMAN_CONSTANT = Observer("KF const", kalman_constant, gains=gains, rates=rates, limit=LIMIT)
