"""A sensor that tells the same number over and over although it has noise: it hangs, or is at the end of its range."""

from __future__ import annotations

import math

import numpy as np

from ...model.arrays import Array
from ..estimate.sizes.noise import noise
from ..kalman.record import FEW
from ..laboratory.gaps import LONGEST_GAP

# noise below this, in F₀ and l₀, is that of digits: there equal numbers mean nothing
NO_NOISE = 1e-6
# steps below this part of a signal are none
_ROUNDING = 1e-12
# a run of equal numbers is no chance if it would come up in fewer recordings than this
_CHANCE = 1e-6


def hanging(time: Array, signal: Array, T: float) -> tuple[float, float] | None:
    """From when to when a signal (n) hangs at longest; None if it never does for longer than a gap may be.

    time: s (n); T: the sampling period in τ. Values of 0 or less may last: a tendon is slack.
    """
    equal = (np.diff(signal) == 0) & (signal[1:] > 0)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], equal, [False]]).astype(np.int8)))
    if not len(edges):
        return None
    starts, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - starts))
    first, last = int(starts[longest]), int(ends[longest])
    elsewhere = np.concatenate([signal[:first], signal[last + 1 :]])
    if time[last] - time[first] <= LONGEST_GAP or len(elsewhere) < FEW:
        return None
    sigma, steps = noise(elsewhere, T).sigma, np.abs(np.diff(elsewhere))
    # the digits of a rounded signal, else next to nothing
    q = float(np.min(steps, where=steps > _ROUNDING * np.max(elsewhere), initial=np.inf))
    if sigma < max(NO_NOISE, q):
        return None
    # P(|ν_{n+1} − ν_n| < q/2), or the share that was seen
    share = (equal.sum() - (last - first)) / len(elsewhere)
    same = max(share, math.erf(q / (4 * sigma)), 1 / len(signal))
    chance = len(signal) * same ** (last - first)
    return (float(time[first]), float(time[last])) if chance < _CHANCE else None
