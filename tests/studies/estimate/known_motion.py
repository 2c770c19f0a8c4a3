"""A recording whose unknown inputs are known, and an observer with some of its numbers."""

import functools
import math
from collections.abc import Mapping

import numpy as np

from hillobs.model.block import Block
from hillobs.model.system import PAIR
from hillobs.observers import OBSERVERS
from hillobs.observers.observer import Sizes
from hillobs.studies.estimate.sizes.first_pass import first_pass
from hillobs.studies.estimate.substeps import substeps
from hillobs.studies.laboratory.laws import Laws
from hillobs.studies.scenarios.paths import paths_of

SIGMA = (1e-3, 4e-4, 4e-4)
# amplitudes and frequencies of Δ_Φ, u₁, u₂, each a sum of sines
MOTION = {
    "Delta": ((0.1, 0.5), (0.05, 0.9)),
    "u1": ((0.1, 0.6), (0.06, 1.1)),
    "u2": ((0.12, 0.45), (0.05, 1.3)),
}


def looked_at(y: np.ndarray, T: float) -> Sizes:
    """The first pass over y1, z1, z2, acc of a mass of 1 that no force but one pulls."""
    y1, z1, z2, acc = y
    # C is no matter: only changes of lengths count
    laws = Laws(PAIR, {"m": 1.0, "C": 0.0})
    return first_pass(laws, np.column_stack([y1, 0 * acc, acc]), np.column_stack([z1, z2]), T).pair


def sines(terms: tuple[tuple[float, float], ...], t: np.ndarray, derivative: int) -> np.ndarray:
    return sum(a * w**derivative * np.sin(w * t + derivative * math.pi / 2) for a, w in terms)


def rms(signal: np.ndarray) -> float:
    return float(np.sqrt(np.mean(signal**2)))


def recorded(
    T: float = 0.05, duration: float = 100, sigma: tuple[float, float, float] = SIGMA, seed: int = 1
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """y1, z1, z2, acc of a motion whose Δ, u₁, u₂ are known; and the truth."""
    t = np.arange(0, duration, T)
    x1 = 3 + 0.2 * np.sin(0.7 * t)
    truth = {"x2": 0.14 * np.cos(0.7 * t), **{name: sines(terms, t, 0) for name, terms in MOTION.items()}}
    clean = [x1, x1 - 1 + sines(MOTION["u1"], t, -1), 5 - x1 + sines(MOTION["u2"], t, -1)]
    noises = np.random.default_rng(seed).normal(size=(3, len(t))) * np.array(sigma)[:, None]
    acc = -0.098 * np.sin(0.7 * t) - truth["Delta"]
    return np.array([*(np.array(clean) + noises), acc]), truth


@functools.cache
def block_of(observer: str) -> Block:
    return OBSERVERS[observer].block(corrected=True)


def steps(observer: str, given: Mapping[str, float], T: float) -> int:
    """Substeps with these numbers (name → value), whatever shares one of them, and defaults."""
    block = block_of(observer)
    values = paths_of([block]).values(block, {f"{observer}.{name}": value for name, value in given.items()})
    return substeps(OBSERVERS[observer], PAIR, block, dict(zip(block.p, values, strict=True)), {}, T)
