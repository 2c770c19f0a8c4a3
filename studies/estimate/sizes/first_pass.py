"""The first pass over a recording: how noisy, how fast and how large what the observers are to follow is.

The constants and what they were measured on: docs/gains.md.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, fields, replace
from typing import TypeVar

import numpy as np

from ....codegen.bank import Bank
from ....codegen.recordings.filters import CompiledBank
from ....model.arrays import Array
from ....model.block import Block, Symbols, symbols
from ....model.symbols import hat
from ....model.system import System
from ....observers.chained import told
from ....observers.high_gain import HIGH_GAIN, chains
from ....observers.observer import JointSizes, MuscleSizes, SystemSizes
from ...kalman.record import FEW
from ...laboratory.laws import Laws
from ..start import at_rest
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

# of a recording too short for statistics
_SHORT_JOINT = JointSizes(sigma=1e-3, eps=0.2, D=0.1, D_max=0.2)
_SHORT_MUSCLE = MuscleSizes(sigma_F=1e-3, sigma_L=1e-3, eps_2=0.05, eps_3=0.1, U=0.1, U_max=0.3)


def first_pass(laws: Laws, y: Array, z: Array, T: float, tau: Array | None = None) -> SystemSizes:
    """The sizes of a recording of finite samples.

    y: what is measured (n × positions and forces); z: tendon lengths Φ_S⁻¹(y) (n × muscles); T: sampling period; tau:
    times (n), if samples are not equidistant. Then T is the median of their distances, noise is that of even steps, and
    where samples are missing straight lines count. Of more than 100,000 samples ten blocks are looked at.
    """
    n, T = len(y), float(T)
    if n < FEW:
        return _short(laws.system, T)
    if n <= _BLOCKS * _BLOCK:
        return _sizes(laws, y, z, T, tau)
    blocks = [slice(start, start + _BLOCK) for start in np.linspace(0, n - _BLOCK, _BLOCKS).astype(int)]
    return _merged([_sizes(laws, y[b], z[b], T, None if tau is None else tau[b]) for b in blocks])


def _short(system: System, T: float) -> SystemSizes:
    """Gains that follow most muscles."""
    least = _FASTEST * T
    joint = replace(_SHORT_JOINT, eps=max(_SHORT_JOINT.eps, least))
    muscle = replace(_SHORT_MUSCLE, eps_2=max(_SHORT_MUSCLE.eps_2, least), eps_3=max(_SHORT_MUSCLE.eps_3, least))
    return SystemSizes(dict.fromkeys(system.joints, joint), dict.fromkeys(system.muscles, muscle))


def _bounded(eps: float, slowest: float, T: float) -> float:
    return max(min(eps, slowest), _FASTEST * T)


def _sizes(laws: Laws, y: Array, z: Array, T: float, tau: Array | None) -> SystemSizes:
    system = laws.system
    joints = len(system.joints)
    even = None if tau is None else even_steps(tau, T)
    of_positions, of_forces, of_lengths = (
        [noise(signal, T, even) for signal in signals.T] for signals in (y[:, :joints], y[:, joints:], z)
    )
    if tau is not None:
        y, z = (filled(signals.T, tau, T).T for signals in (y, z))
    q = _cleaned(y[:, :joints], [nu.sigma for nu in of_positions])
    lengths = _cleaned(z, [nu.sigma for nu in of_lengths])
    # forces count as acceleration too
    acc = laws.accelerations(y[:, :joints], _speeds(q, of_positions, T), y[:, joints:])
    acc = _cleaned(acc, [_SPREAD * float(np.ptp(signal)) for signal in acc.T])
    driven = T * laws.acceleration_noise(y[:, :joints], y[:, joints:], [nu.sigma for nu in of_forces])

    # y₁ − ∬(y₃ − y₂)/m: its second derivative is Δ_Φ
    eps, smooth = [], []
    for position, known, nu, density in zip(q.T, acc.T, of_positions, driven, strict=True):
        moved = twice_integrated(known, T)
        eps.append(_bounded(_C1 * time_scale(position - moved, 3, nu, T, density), _SLOWEST_1, T))
        smooth.append(moved + smoothed(position - moved, T, eps[-1]))
    # L_S − L_m: its derivatives are u and so on
    rest = lengths - laws.lengths(np.stack(smooth, axis=1))
    eps_2, eps_3 = (
        _of_muscles(system, [time_scale(s, k, nu, T) for s, nu in zip(rest.T, of_lengths, strict=True)], c, T)
        for c, k in ((_CL, 2), (_CL3, 3))
    )
    noises = zip(of_forces, of_lengths, strict=True)
    sizes = SystemSizes(
        {
            name: JointSizes(nu.sigma, e, _LEAST, _LEAST)
            for name, nu, e in zip(system.joints, of_positions, eps, strict=True)
        },
        {
            name: MuscleSizes(F.sigma, L.sigma, e2, e3, _LEAST, _LEAST)
            for name, (F, L), e2, e3 in zip(system.muscles, noises, eps_2, eps_3, strict=True)
        },
    )
    return _with_inputs(system, sizes, np.column_stack([q, lengths, acc]), of_positions, T)


def _cleaned(signals: Array, spreads: Sequence[float]) -> Array:
    return np.array([despiked(*pair) for pair in zip(signals.T, spreads, strict=True)]).T


def _speeds(q: Array, noises: Sequence[Noise], T: float) -> Array:
    """Velocities for what depends on them little: dampers, and how links swing each other."""
    scales = [_bounded(_C1 * time_scale(s, 3, nu, T), _SLOWEST_1, T) for s, nu in zip(q.T, noises, strict=True)]
    smooth = [smoothed(signal, T, eps) for signal, eps in zip(q.T, scales, strict=True)]
    return np.gradient(np.stack(smooth, axis=1), T, axis=0)


def _of_muscles(system: System, scales: Sequence[float], c: float, T: float) -> list[float]:
    """ε of each muscle; the pair's two have one, as in the paper."""
    if system.paper:
        scales = [math.sqrt(math.prod(scales))] * len(scales)
    return [_bounded(c * scale, _SLOWEST_L, T) for scale in scales]


def _with_inputs(
    system: System, sizes: SystemSizes, signals: Array, of_positions: Sequence[Noise], T: float
) -> SystemSizes:
    """D, D_max, U, U_max as the high gain observer sees them."""
    compiled = compile_first_pass(system)
    block = compiled.bank.observers[0]
    numbers = {name: parameter.default for name, parameter in block.parameters.items()}
    numbers |= HIGH_GAIN.gains_of(system, sizes, T)
    numbers |= at_rest(system, signals[0, : len(system.joints) + len(system.muscles)].tolist())
    n = len(signals)
    times: Array = np.arange(n, dtype=float) * T
    steps = substeps(HIGH_GAIN, system, block, numbers, {}, T)
    estimates = compiled.follow(block.name, list(numbers.values()), steps).samples(times, signals).y
    slowest = max(*(joint.eps for joint in sizes.joints.values()), *(m.eps_2 for m in sizes.muscles.values()))
    settled = estimates[min(math.ceil(_SETTLED * slowest / T), n // _PART) :]

    def of(*names: str) -> Array:
        return settled[:, [list(block.y).index(hat(name)) for name in names]]

    joints = {
        name: _of_joint(joint, of(Delta), nu, T)
        for (name, joint), Delta, nu in zip(sizes.joints.items(), system.joint("Delta"), of_positions, strict=True)
    }
    together = [of(*system.muscle("u"))] * len(system.muscles) if system.paper else map(of, system.muscle("u"))
    muscles = {
        name: replace(muscle, **_of_input(u)) for (name, muscle), u in zip(sizes.muscles.items(), together, strict=True)
    }
    return SystemSizes(joints, muscles)


def _of_joint(joint: JointSizes, Delta: Array, nu: Noise, T: float) -> JointSizes:
    # D² = mean Δ̂² − 3/16 σ₁² n_c T/ε₁⁵
    passed = _PASSED * nu.sigma**2 * nu.correlation * T / joint.eps**5
    largest = _largest(Delta)
    D = math.sqrt(max(float(np.mean(Delta**2)) - passed, _LEAST**2))
    # a few wild values may lift the mean above what nearly all stay below
    return replace(joint, D=min(D, largest), D_max=largest)


def _of_input(u: Array) -> dict[str, float]:
    largest = _largest(u)
    return {"U": min(math.sqrt(max(float(np.mean(u**2)), _LEAST**2)), largest), "U_max": largest}


def _largest(signals: Array) -> float:
    return max(float(np.quantile(np.abs(signals), _SHARE)), _LEAST)


@functools.lru_cache(maxsize=8)
def compile_first_pass(system: System) -> CompiledBank:
    """The high gain observer, told tendon lengths and accelerations instead of forces."""
    lengths, accelerations = system.tendons, [f"acc.{joint}" for joint in system.joints]
    observer = told(chains(), system)
    u = symbols([f"measured.{name}" for name in (*lengths, *accelerations)])
    y = Symbols({name.removeprefix("measured."): symbol for name, symbol in u.items()})
    front = Block("measured", u=u, y=y)
    measured = (*system.joint("y"), *u)
    return CompiledBank(Bank(measured, front, None, (observer,)))


def _merged(blocks: list[SystemSizes]) -> SystemSizes:
    """Of the blocks of a recording: the median noise, the mean logarithm of ε, mean squares, the largest values."""
    first = blocks[0]
    return SystemSizes(
        {name: _together([block.joints[name] for block in blocks]) for name in first.joints},
        {name: _together([block.muscles[name] for block in blocks]) for name in first.muscles},
    )


def _median(values: Array) -> float:
    return float(np.median(values))


def _geometric(values: Array) -> float:
    return float(np.exp(np.mean(np.log(values))))


def _square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


_HOW: Mapping[str, Callable[[Array], float]] = {
    **dict.fromkeys(("sigma", "sigma_F", "sigma_L"), _median),
    **dict.fromkeys(("eps", "eps_2", "eps_3"), _geometric),
    **dict.fromkeys(("D", "U"), _square),
    **dict.fromkeys(("D_max", "U_max"), lambda values: float(np.max(values))),
}
S = TypeVar("S", JointSizes, MuscleSizes)


def _together(sizes: list[S]) -> S:
    columns = np.array([astuple(one) for one in sizes]).T
    return type(sizes[0])(*(_HOW[field.name](column) for field, column in zip(fields(sizes[0]), columns, strict=True)))
