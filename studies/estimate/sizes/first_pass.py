"""The first pass over a recording: how noisy, how fast and how large what the observers are to follow is.

The constants and what they were measured on: docs/gains.md.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import asdict, astuple, fields

import casadi as ca
import numpy as np

from ....codegen.bank import Bank
from ....codegen.recordings.filters import CompiledBank
from ....model.arrays import Array
from ....model.block import Block, Symbols, symbols
from ....model.skeleton import pull
from ....observers.high_gain import HIGH_GAIN
from ....observers.observer import Sizes
from ..substeps import substeps
from .noise import Noise, despiked, even_steps, noise
from .timescales import filled, smoothed, time_scale, twice_integrated

# ε over the time scale: the width of an observer's window where it averages as much noise as it loses signal
_C1, _CL, _CL3 = 0.35, 0.27, 0.35
# smallest ε in sampling periods: what a straight line between samples supports
_FASTEST = 0.7
# largest ε: nothing is slower than the muscle itself, and a late disturbance must still be followed
_SLOWEST_1, _SLOWEST_L = 0.5, 0.3
# Δ̂ and û are judged after this many ε, but no later than this part of the samples
_SETTLED, _PART = 10.0, 4
# the largest value is the one that this share does not exceed
_SHARE = 0.995
# smallest sizes of Δ_Φ and u, so that gains stay positive
_LEAST = 0.02
# variance of Δ̂ from noise of y₁, of a triple pole: (1/2π) ∫ω⁴/(1 + ω²)³ dω = 3/16
_PASSED = 3 / 16
# the acceleration, whose noise is not measured, is wild beyond 8 · 2 % of its range
_SPREAD = 0.02
# of a long recording: number of blocks that are looked at, and samples of each
_BLOCKS, _BLOCK = 10, 10_000
# statistics of fewer samples are none
FEW = 50

# of a recording too short for statistics
_SHORT = Sizes(1e-3, 1e-3, 1e-3, 1e-3, 1e-3, eps_1=0.2, eps_L=0.05, eps_L3=0.1, D=0.1, D_max=0.2, U=0.1, U_max=0.3)


def first_pass(y: Array, z: Array, m: float, T: float, tau: Array | None = None) -> Sizes:
    """The sizes of a recording of finite samples.

    y: what is measured (3 × n); z: tendon lengths Φ_S⁻¹(y₂), Φ_S⁻¹(y₃) (2 × n); m: mass; T: sampling period; tau: times
    (n), if samples are not equidistant. Then T is the median of their distances, noise is that of even steps, and where
    samples are missing straight lines count. Of more than 100,000 samples ten blocks are looked at.
    """
    # acc = R F/m
    signals, T = np.vstack([y, z, pull(y[1:]) / m]), float(T)
    n = signals.shape[1]
    if n < FEW:
        least = {name: max(getattr(_SHORT, name), _FASTEST * T) for name in ("eps_1", "eps_L", "eps_L3")}
        return Sizes(**{**asdict(_SHORT), **least})
    if n <= _BLOCKS * _BLOCK:
        return _sizes(signals, T, tau)
    blocks = [slice(start, start + _BLOCK) for start in np.linspace(0, n - _BLOCK, _BLOCKS).astype(int)]
    return _merged([_sizes(signals[:, block], T, None if tau is None else tau[block]) for block in blocks])


def _sizes(signals: Array, T: float, tau: Array | None) -> Sizes:
    even = None if tau is None else even_steps(tau, T)
    noises = [noise(signal, T, even) for signal in signals[:-1]]
    if tau is not None:
        signals = filled(signals, tau, T)
    sigma_1, sigma_F1, sigma_F2, sigma_L1, sigma_L2 = (nu.sigma for nu in noises)
    # forces count as lengths and as acceleration
    seen, spreads = signals[[0, 3, 4, 5]], [sigma_1, sigma_L1, sigma_L2, _SPREAD * float(np.ptp(signals[-1]))]
    y1, z1, z2, acc = clean = np.array([despiked(*pair) for pair in zip(seen, spreads, strict=True)])

    def bounded(eps: float, slowest: float) -> float:
        return max(min(eps, slowest), _FASTEST * T)

    # y₁ − ∬(y₃ − y₂)/m: its second derivative is Δ_Φ
    moved = twice_integrated(acc, T)
    eps_1 = bounded(_C1 * time_scale(y1 - moved, 3, noises[0], T), _SLOWEST_1)
    # L_S1 − x₁ and L_S2 + x₁: their derivatives are u₁ and u₂
    x1 = moved + smoothed(y1 - moved, T, eps_1)

    def chain(c: float, order: int) -> float:
        first, second = (time_scale(z, order, nu, T) for z, nu in zip((z1 - x1, z2 + x1), noises[3:], strict=True))
        return bounded(c * math.sqrt(first * second), _SLOWEST_L)

    eps_L, eps_L3 = chain(_CL, 2), chain(_CL3, 3)
    inputs = _inputs(clean, T, eps_1, eps_L, noises[0])
    return Sizes(sigma_1, sigma_F1, sigma_F2, sigma_L1, sigma_L2, eps_1, eps_L, eps_L3, *inputs)


def _inputs(signals: Array, T: float, eps_1: float, eps_L: float, noise_1: Noise) -> tuple[float, float, float, float]:
    """D, D_max, U, U_max as the high gain observer sees them."""
    compiled = compile_first_pass()
    block = compiled.bank.observers[0]
    numbers = {name: parameter.default for name, parameter in block.parameters.items()}
    # forces of a mass of 1
    numbers |= {"eps_h": eps_1, "eps_L": eps_L, "m": 1.0, "initial.x2_hat": 0.0}
    numbers |= {f"initial.x{i}_hat": float(value) for i, value in zip((1, 3, 4), signals[:3, 0], strict=True)}
    n = signals.shape[1]
    times: Array = np.arange(n, dtype=float) * T
    steps = substeps(HIGH_GAIN, block, numbers, {}, T)
    estimates = compiled.follow(block.name, list(numbers.values()), steps).samples(times, signals.T).y
    settled = estimates[min(math.ceil(_SETTLED * max(eps_1, eps_L) / T), n // _PART) :]
    Delta = settled[:, list(block.y).index("Delta_hat")]
    u = settled[:, [list(block.y).index(name) for name in ("u1_hat", "u2_hat")]]
    # D² = mean Δ̂² − 3/16 σ₁² n_c T/ε₁⁵
    passed = _PASSED * noise_1.sigma**2 * noise_1.correlation * T / eps_1**5
    D_max, U_max = (max(float(np.quantile(np.abs(signal), _SHARE)), _LEAST) for signal in (Delta, u))
    D = math.sqrt(max(float(np.mean(Delta**2)) - passed, _LEAST**2))
    U = math.sqrt(max(float(np.mean(u**2)), _LEAST**2))
    # a few wild values may lift the mean above what nearly all stay below
    return min(D, D_max), D_max, min(U, U_max), U_max


@functools.cache
def compile_first_pass() -> CompiledBank:
    """The high gain observer, told tendon lengths and accelerations instead of forces."""
    u = symbols("z1 z2 acc")
    front = Block("measured", u=u, y=Symbols(y2=ca.SX(0), y3=u.acc, L_S1=u.z1, L_S2=u.z2))
    return CompiledBank(Bank(("y1", "z1", "z2", "acc"), front, None, (HIGH_GAIN.build(),)))


def _merged(blocks: list[Sizes]) -> Sizes:
    """Of the blocks of a recording: the median noise, the mean logarithm of ε, mean squares, the largest values."""

    def median(values: Array) -> float:
        return float(np.median(values))

    def geometric(values: Array) -> float:
        return float(np.exp(np.mean(np.log(values))))

    def square(values: Array) -> float:
        return float(np.sqrt(np.mean(values**2)))

    def largest(values: Array) -> float:
        return float(np.max(values))

    how: dict[str, Callable[[Array], float]] = {
        **dict.fromkeys(("sigma_1", "sigma_F1", "sigma_F2", "sigma_L1", "sigma_L2"), median),
        **dict.fromkeys(("eps_1", "eps_L", "eps_L3"), geometric),
        **dict.fromkeys(("D", "U"), square),
        **dict.fromkeys(("D_max", "U_max"), largest),
    }
    columns = np.array([astuple(block) for block in blocks]).T
    return Sizes(*(how[field.name](column) for field, column in zip(fields(Sizes), columns, strict=True)))
