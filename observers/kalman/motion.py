"""The motion from sample to sample: e^{AT} in closed form, of a mass that swings on its two tendons.

With z_j = Φ_S⁻¹(y_{j+1}) and p_j = Φ′_S(z_j) the acceleration is linear in the state,

    ẋ₂ = acc + (p₂(x₄ − z₂) − p₁(x₃ − z₁))/m + Δ,   acc = (y₃ − y₂)/m,   Ω² = (p₁ + p₂)/m

so errors of the measured forces are errors of x₃ and x₄, and those are in the covariance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import casadi as ca

from .states import CHAINS, INDEX, LONGEST

# φ_k up to here: what the last derivative in a chain of u adds to ∫x₂
_HIGHEST = LONGEST + 2
# terms of the series of φ_k: the next one is below 1e−17 as long as (ΩT)² is below its limit
_TERMS, _LARGEST = 24, 10.0**2
# ∫x₂ from sample to sample
_WAY = "way"
# keeps 0/0 out of the limit where no time has passed
_NO_TIME = 1e-300


class Motion:
    """What happens within a time T, for slopes p₁, p₂ of the tendons over that time."""

    def __init__(self, p1: ca.SX, p2: ca.SX, m: ca.SX, T: ca.SX) -> None:
        # where samples miss the swing by far, ΩT > 10, the series would lose digits: tendons count as softer
        softer = ca.fmin(1, _LARGEST * m / ca.fmax((p1 + p2) * T**2, _NO_TIME))
        self.pull1, self.pull2, self._T = softer * p1 / m, softer * p2 / m, T
        self._phi = _phi((self.pull1 + self.pull2) * T**2)
        # cos ΩT, sin(ΩT)/Ω, (1 − cos ΩT)/Ω², …: each the integral of the one before
        self._c = [T**k * phi for k, phi in enumerate(self._phi)]

    def factors(self) -> tuple[ca.SX, ca.SX]:
        """Sparse C and B with e^{AT} = C B: all lengths share ∫x₂, which B computes once."""
        T, c = self._T, self._c
        x2 = {"x2": c[0], "x3": -self.pull1 * c[1], "x4": self.pull2 * c[1]}
        way = {"x2": c[1], "x3": -self.pull1 * c[2], "x4": self.pull2 * c[2]}
        for i, (Delta, u1, u2) in enumerate(zip(*CHAINS.values(), strict=True)):
            x2 |= {Delta: c[i + 1], u1: -self.pull1 * c[i + 2], u2: self.pull2 * c[i + 2]}
            way |= {Delta: c[i + 2], u1: -self.pull1 * c[i + 3], u2: self.pull2 * c[i + 3]}
        # the rest moves on its own: 1, T, T²/2, …
        powers = [T**j / math.factorial(j) for j in range(LONGEST + 1)]
        alone = [chain[i:] for chain in CHAINS.values() for i in range(LONGEST)]
        alone += [("x1",), ("x3", *CHAINS["u1"]), ("x4", *CHAINS["u2"])]
        rows = {chain[0]: dict(zip(chain, powers, strict=False)) for chain in alone}
        # full rows come last: then the lower triangle of B P Bᵀ is cheap
        B = _sparse([*rows, "x2", _WAY], INDEX, {**rows, "x2": x2, _WAY: way})
        # x₁⁺ = x₁ + ∫x₂,  x₃⁺ = x₃ + ∫u₁ + ∫x₂,  x₄⁺ = x₄ + ∫u₂ − ∫x₂
        shared = {"x1": 1, "x3": 1, "x4": -1}
        added = {row: {row: 1, **({_WAY: shared[row]} if row in shared else {})} for row in INDEX}
        return _sparse(INDEX, [*rows, "x2", _WAY], added), B

    def driven(self, before: ca.SX, after: ca.SX) -> ca.SX:
        """What an acceleration that goes straight from `before` to `after` adds to the state (n × 1)."""
        T, rise = self._T, after - before
        x2 = T * (self._phi[1] * before + self._phi[2] * rise)
        way = T**2 * (self._phi[2] * before + self._phi[3] * rise)
        added = ca.SX(len(INDEX), 1)
        for row, value in (("x1", way), ("x2", x2), ("x3", way), ("x4", -way)):
            added[INDEX[row]] = value
        return added


def _sparse(rows: Iterable[str], columns: Iterable[str], entries: Mapping[str, Mapping[str, ca.SX | float]]) -> ca.SX:
    rows, columns = list(rows), list(columns)
    result = ca.SX(len(rows), len(columns))
    for i, row in enumerate(rows):
        for column, value in entries[row].items():
            result[i, columns.index(column)] = value
    return result


def _phi(z: ca.SX) -> list[ca.SX]:
    """φ_k(z) = Σ (−z)ʲ/(k + 2j)!, k = 0 … 5: the entire functions with φ_0(x²) = cos x, φ_1(x²) = sin(x)/x."""
    phi = [ca.SX(0)] * (_HIGHEST + 1)
    for k in (_HIGHEST, _HIGHEST - 1):
        value = ca.SX(0)
        for j in reversed(range(_TERMS)):
            value = 1 / math.factorial(k + 2 * j) - z * value
        phi[k] = value
    for k in reversed(range(_HIGHEST - 1)):
        # φ_k = 1/k! − z φ_{k+2}
        phi[k] = 1 / math.factorial(k) - z * phi[k + 2]
    return phi
