"""How fast a recorded signal is: the shortest time after which it leaves what its noise hides.

The constants and what they were measured on: docs/gains.md.
"""

from __future__ import annotations

import numpy as np

from ....model.arrays import Array
from .noise import Noise, differences

# lags in an octave; the longest, in τ; the part of the samples that each must leave to look at
_PER_OCTAVE, _LONGEST, _PART = 6, 3.0, 4
# in samples: shorter lags are looked at however far apart the samples are
_FEW = 8
# noise averaged over n samples is compared as if averaged over n/8: then one constant fits all sampling rates
_AVERAGED = 8.0
# times as many samples as there are: more would be nearly all made up
_MOST = 2
# what stands for no noise at all, and for no signal at all beside the noise
_NO_NOISE, _NO_SIGNAL = 1e-30, 1e-3


def time_scale(signal: Array, order: int, noise: Noise, T: float, density: float = 0.0) -> float:
    """The lag, in τ, from which the differences of this order stand out of the averaged noise for an octave.

    The longest lag if they never do. density: of white noise that was integrated twice into the signal, order 3.
    """
    n, S = structure(signal, order, T)
    # (S_k(n) − C(2k, k)σ²) / (C(2k, k)σ² · 8n_c/n); the third difference of ∬w at the lag h has the variance q h³
    alone = noise.difference(order) + density * (n * T) ** 3
    ratio = (S - alone) / np.maximum(alone * _AVERAGED * noise.correlation / n, _NO_NOISE)
    above = ratio > 1
    i = next((i for i in range(len(n)) if above[i : i + _PER_OCTAVE].all()), len(n) - 1)
    if i == 0 or not above[i]:
        return float(n[i] * T)
    # where the line through both points crosses 1, in logarithms
    low, high = np.log(max(ratio[i - 1], _NO_SIGNAL)), np.log(ratio[i])
    return float(n[i - 1] * (n[i] / n[i - 1]) ** (-low / (high - low)) * T)


def structure(signal: Array, order: int, T: float) -> tuple[Array, Array]:
    """Lags in samples, and the structure function S_k there: the mean square of the differences of that order."""
    octaves = np.log2(max(len(signal), 2))
    n = np.unique(np.round(2 ** np.arange(0, octaves, 1 / _PER_OCTAVE)))
    n = n[(n * order <= max(len(signal) // _PART, order)) & (n <= max(_LONGEST / T, _FEW))]
    return n, np.array([np.mean(differences(signal, order, int(lag)) ** 2) for lag in n])


def filled(signals: Array, tau: Array, T: float) -> Array:
    """Signals (k × n) with straight lines where samples T apart are missing; as they are if most are missing."""
    places = np.concatenate([[0.0], np.cumsum(np.maximum(np.round(np.diff(tau) / T), 1.0))])
    if places[-1] == len(tau) - 1 or places[-1] > _MOST * len(tau):
        return signals
    n: Array = np.arange(places[-1] + 1)
    return np.array([np.interp(n, places, signal) for signal in signals])


def twice_integrated(acc: Array, T: float) -> Array:
    """The way that an acceleration makes from rest at 0; a straight line between samples, so exact for it."""
    # v(n) = v(n−1) + T(a₀ + a₁)/2,  p(n) = p(n−1) + T v(n−1) + T²(2a₀ + a₁)/6
    before, after = acc[:-1], acc[1:]
    v = np.concatenate([[0.0], np.cumsum(T * (before + after) / 2)])
    return np.concatenate([[0.0], np.cumsum(T * v[:-1] + T**2 * (2 * before + after) / 6)])


def smoothed(signal: Array, T: float, tau: float) -> Array:
    """Two low passes of time constant tau forward and two backward: no lag. As it is if tau is below T."""
    if tau < T:
        return signal
    # without the line from end to end, continued as an odd function, it is periodic and has no jump
    line = np.linspace(signal[0], signal[-1], len(signal))
    rest = signal - line
    odd = np.concatenate([rest, -rest[-2:0:-1]])
    # |H(ω)|² = (1 − a)²/(1 − 2a cos ω + a²),  a = e^(−T/τ)
    a, omega = np.exp(-T / tau), np.linspace(0, np.pi, len(odd) // 2 + 1)
    once = (1 - a) ** 2 / (1 - 2 * a * np.cos(omega) + a**2)
    both: Array = np.fft.irfft(np.fft.rfft(odd) * once**2, len(odd))
    return both[: len(signal)] + line
