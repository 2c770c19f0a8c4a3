"""Sensor noise: Philox4x32-10, a uniform number of each seed, channel and sample, the error of each sensor."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .parameters import Parameters, value
from .states import Array

# Random123 (Salmon, Moraes, Dror, Shaw, SC 2011), file tests/kat_vectors, generator philox4x32, 10 rounds
PHILOX_VECTORS = (
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    ((0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344), (0xA4093822, 0x299F31D0),
     (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1)),
)  # fmt: skip


def philox4x32(counter: Sequence[Any], key: Sequence[Any]) -> tuple[NDArray[np.uint32], ...]:
    """Philox4x32-10 for arrays of counters and keys."""
    M0, M1, low = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57), np.uint64(0xFFFFFFFF)
    c0, c1, c2, c3, k0, k1 = np.broadcast_arrays(*(np.asarray(w, np.uint64) for w in (*counter, *key)))
    for _ in range(10):
        p0, p1 = M0 * c0, M1 * c2  # 32 × 32 → 64 bits
        c0, c1, c2, c3 = (p1 >> np.uint64(32)) ^ c1 ^ k0, p1 & low, (p0 >> np.uint64(32)) ^ c3 ^ k1, p0 & low
        k0, k1 = (k0 + np.uint64(0x9E3779B9)) & low, (k1 + np.uint64(0xBB67AE85)) & low
    return tuple(w.astype(np.uint32) for w in (c0, c1, c2, c3))


def uniform(seed: Any, channel: Any, sample: Any) -> Array:
    """U(−1, 1] of a seed, a channel (0: x1, 1: force 1, 2: force 2) and a sample's index; the arguments broadcast."""
    seed = np.asarray(seed, np.uint64)
    key = (seed & np.uint64(0xFFFFFFFF), seed >> np.uint64(32))
    w0, w1, _, _ = philox4x32((sample, channel, 0, 0), key)
    # U = 2((w₀ ≫ 5)·2²⁶ + (w₁ ≫ 6) + ½)/2⁵³ − 1
    return 2 * ((w0 >> np.uint32(5)) * 2.0**26 + (w1 >> np.uint32(6)) + 0.5) / 2.0**53 - 1


def sensor_noise(p: Parameters, seeds: Sequence[int], samples: int) -> Array:
    """What is added to (y₁, y₂, y₃): shape (samples, 3, seeds)."""
    U = uniform(np.asarray(seeds, np.uint64), np.arange(3)[:, None], np.arange(samples)[:, None, None])
    # ν = (n_x U₀, drift + n_F U₁, drift + n_F U₂)
    scale = np.array([value(p, "noise.x1"), value(p, "noise.force"), value(p, "noise.force")])
    return np.array([0.0, 1.0, 1.0])[:, None] * value(p, "noise.drift") + scale[:, None] * U
