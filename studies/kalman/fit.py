"""Densities by maximum likelihood: a fixed point of the score, whose terms one filter and one smoother give.

∂log L/∂(s²) = ½ Σ T(λ_i² − Λ_ii) = 0   ⇒   s² ← s² ΣTλ_i²/ΣTΛ_ii
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...model.arrays import Array
from .passes import CompiledPasses, log_likelihood

# the largest factor of s² in one step
_STEP = 30.0
# log L has come to rest when it rises by less, or no s² by this part
_RISE, _PART = 0.5, 0.05
# more steps gain nothing that the likelihood can tell
_MOST = 60


@dataclass(frozen=True)
class Fit:
    """The numbers (name → value) at the largest likelihood, its logarithm, and how many passes that took."""

    numbers: Mapping[str, float]
    log_likelihood: float
    passes: int


def fitted(
    passes: CompiledPasses, segments: Sequence[Array], numbers: Mapping[str, float], least: Mapping[str, float]
) -> Fit:
    """The √densities in `least` (name → smallest value) that make the recording likeliest, from `numbers` on.

    segments: tables of samples, each filtered from its own start.
    """
    best = Fit(numbers, -math.inf, 0)
    moving = [(segment, passes.motions(numbers, segment)) for segment in segments]
    trial, taken = dict(numbers), 0
    for _ in range(_MOST):
        value, score = _scored(passes, moving, trial)
        taken += 2
        rise = value - best.log_likelihood
        if rise > 0:
            best = Fit(dict(trial), value, taken)
        if rise < _RISE:
            break
        factors = {name: min(max(ratio, 1 / _STEP), _STEP) for name, ratio in _ratios(passes, score)}
        moved = {name: max(trial[name] * math.sqrt(factors[name]), smallest) for name, smallest in least.items()}
        if all(abs((value / trial[name]) ** 2 - 1) < _PART for name, value in moved.items()):
            break
        trial |= moved
    return Fit(best.numbers, best.log_likelihood, taken)


def _ratios(passes: CompiledPasses, score: Array) -> Iterator[tuple[str, float]]:
    """ΣTλ²/ΣTΛ of each density."""
    for name, (found, expected) in zip(passes.densities, score, strict=True):
        yield name, float(found / expected) if expected > 0 else 1.0


def _scored(
    passes: CompiledPasses, moving: Sequence[tuple[Array, Array]], numbers: Mapping[str, float]
) -> tuple[float, Array]:
    total, score = 0.0, np.zeros((len(passes.densities), 2))
    for segment, motions in moving:
        filtered = passes.filtered(numbers, passes.start(numbers, segment[0]), segment, motions)
        total += log_likelihood(filtered, segment)
        score += passes.smoothed(numbers, segment, motions, filtered).score
    return total, score
