"""How noisy a recorded signal is, over how many samples its noise is correlated, and which samples are wild.

The constants and what they were measured on: docs/gains.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....model.arrays import Array

# differences of this order leave nothing of a smooth signal at the distance of samples
_ORDER = 5
# longest lag, in τ, over which noise may be correlated; the part of the samples that must be left to look at
_LONGEST, _PART = 0.15, 4
# white noise gives the same at each lag, a smooth signal 2⁵ times as much at the double lag
_LEVEL = 1.5
# parts of the usual step by which one may differ; differences over even steps alone from which statistics are made
_JITTER, _ENOUGH = 0.05, 200
# standard deviation over median of the absolute value, of a normal distribution
_NORMAL = 1.4826
# part of neighbours that are equal if a signal was rounded; steps below this part of its size are none
_EQUAL, _NO_STEP = 0.1, 1e-12
# a wild sample lies so far off the median of its neighbourhood, in σ and in parts of the range; more are no accident
_SAMPLES, _SIGMAS, _RANGE, _MOST = 5, 8.0, 0.002, 0.02


@dataclass(frozen=True)
class Noise:
    """Standard deviation of a signal's noise, and over how many samples it is correlated (1 if white)."""

    sigma: float
    correlation: int = 1

    def difference(self, order: int) -> float:
        """Mean square of the differences of this order of the noise alone."""
        # E(Δᵏ ν)² = C(2k, k) σ²
        return math.comb(2 * order, order) * self.sigma**2


def even_steps(time: Array, T: float) -> NDArray[np.bool_]:
    """Which steps from sample to sample (n − 1) are as long as usual, T."""
    return np.abs(np.diff(time) - T) <= _JITTER * T


def noise(signal: Array, T: float, even: NDArray[np.bool_] | None = None) -> Noise:
    """The noise of equidistant samples, T apart; of others by those parts that are, if there are enough of them.

    even: which steps from sample to sample are T, all by default.

    A hardware filter makes noise smooth from sample to sample; then the estimate grows with the lag, until that is
    longer than the noise is correlated. Without noise it never stops growing, and lag 1 counts.
    """
    floor = _quantum(signal) / math.sqrt(12)
    uneven = None if even is None or even.all() else np.concatenate([[0], np.cumsum(~even)])
    first = before = _spread(signal, 1, uneven)
    lag = 1
    while 2 * lag * T <= _LONGEST and 2 * lag * _ORDER < len(signal) // _PART:
        after = _spread(signal, 2 * lag, uneven)
        if after < _LEVEL * before:
            return Noise(max(floor, first if lag == 1 else max(before, after)), lag)
        lag, before = 2 * lag, after
    return Noise(max(floor, first))


def despiked(signal: Array, sigma: float) -> Array:
    """`signal` with straight lines in place of single wild samples; as it is if they are too many."""
    padded = np.pad(signal, _SAMPLES // 2, mode="edge")
    around = np.median(np.lib.stride_tricks.sliding_window_view(padded, _SAMPLES), axis=-1)
    wild = np.abs(signal - around) > _SIGMAS * sigma + _RANGE * np.ptp(signal)
    if not 0 < wild.mean() < _MOST:
        return signal
    # the median itself is off where the signal moves
    n = np.arange(len(signal))
    return np.where(wild, np.interp(n, n[~wild], signal[~wild]), signal)


def differences(signal: Array, order: int, lag: int) -> Array:
    """Σ (−1)ⁱ C(k, i) q(n − i·lag), for all n that have so many samples before them."""
    for _ in range(order):
        signal = signal[lag:] - signal[:-lag]
    return signal


def _spread(signal: Array, lag: int, uneven: NDArray[np.int64] | None) -> float:
    """σ = 1.4826 MAD(Δ⁵)/√252; uneven: how many steps before each sample are not as long as usual."""
    change = differences(signal, _ORDER, lag)
    if uneven is not None:
        whole = uneven[_ORDER * lag :] == uneven[: -_ORDER * lag]
        # where steps differ a difference has something of the signal left
        change = change[whole] if whole.sum() >= _ENOUGH else change
    middle = float(np.median(np.abs(change - np.median(change))))
    return _NORMAL * middle / math.sqrt(math.comb(2 * _ORDER, _ORDER))


def _quantum(signal: Array) -> float:
    """The smallest step of a rounded signal; 0 if it was not rounded."""
    steps = np.abs(np.diff(signal))
    moved = steps > _NO_STEP * np.max(np.abs(signal))
    return float(steps[moved].min()) if moved.any() and moved.mean() < 1 - _EQUAL else 0.0
