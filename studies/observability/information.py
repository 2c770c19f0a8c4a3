"""How well the coordinates can be known: the Fisher information of noisy samples along the motion."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from ...codegen.stepper import STAGES, functions
from ...model.arrays import Array
from ...model.block import Block

# information below this part of the largest is rounding, and so is a coordinate that has this share of it
_ROUNDING, _SHARE = 1e-13, 1e-6
# |λ|h at which RK4 is stable (2.6 where it is least, 2.8 on both axes); more steps take a minute
_STABLE, _MOST_STEPS = 2.5, 20_000


def deviations(
    block: Block,
    start: tuple[Sequence[float], Sequence[float]],
    p: Sequence[float],
    noise: Mapping[str, float],
    sizes: Mapping[str, float],
    period: float,
    window: float = 1.0,
) -> dict[str, float]:
    """Smallest standard deviation with which each coordinate at the start of `window` can be known from it.

    Cramér–Rao bound for the motion from `start` (states, known inputs) with constant inputs: the outputs in `noise`
    (name → half-width of its uniform noise) are sampled once per `period` with independent errors of that variance.
    No prior knowledge; inf where the samples hold no information, NaN if the motion is too fast to be computed.
    """
    x, u = (np.array(values, dtype=float) for values in start)
    step, outputs, slope = _linearised(block, tuple(noise))
    count, steps = max(1.0, window / period), _steps(np.array(slope(x, u, p), dtype=float), period)
    if not count * steps <= _MOST_STEPS:
        return dict.fromkeys(sizes, math.nan)
    # R = σ²,  σ = half-width/√3 of the uniform noise
    weights = 3 / np.array(list(noise.values())) ** 2
    n = len(x)
    information, transition = np.zeros((n, n)), np.eye(n)
    for _ in range(round(count)):
        C = np.array(outputs(x, u, p), dtype=float) @ transition
        # I = Σ Φₖᵀ Cᵀ R⁻¹ C Φₖ
        information += C.T @ (weights[:, None] * C)
        for _ in range(round(steps)):
            after, A = step(period / steps, x, u, p)
            x, transition = np.array(after, dtype=float).ravel(), np.array(A, dtype=float) @ transition
    return _bound(information, sizes)


def _steps(A: Array, period: float) -> float:
    """RK4 steps in a sampling period with which it is stable where ∂ẋ/∂x is A; inf if there is no such number."""
    if not np.isfinite(A).all():
        return math.inf
    return max(1.0, math.ceil(float(np.abs(np.linalg.eigvals(A)).max()) * period / _STABLE))


def _bound(information: Array, sizes: Mapping[str, float]) -> dict[str, float]:
    scales = np.array(list(sizes.values()))
    scaled = information * np.outer(scales, scales)
    if not np.isfinite(scaled).all():
        return dict.fromkeys(sizes, math.nan)
    values, vectors = np.linalg.eigh(scaled)
    known = values > _ROUNDING * values[-1]
    spread = (vectors[:, known] ** 2 / values[known]).sum(axis=1)
    blind = (vectors[:, ~known] ** 2).sum(axis=1) > _SHARE
    return {
        name: float("inf") if lost else float(size * np.sqrt(s))
        for name, size, s, lost in zip(sizes, scales, spread, blind, strict=True)
    }


@functools.cache
def _linearised(block: Block, outputs: tuple[str, ...]) -> tuple[ca.Function, ca.Function, ca.Function]:
    """One step and its derivative, the derivatives of outputs and of ẋ, with respect to the coordinates."""
    step = functions(block, (), tuple(block.u))["step"]
    groups = {"x": block.x, "u": block.u, "p": block.p}
    h, x, u, p = (ca.SX.sym("h"), *(ca.SX.sym(name, len(group)) for name, group in groups.items()))
    after, _ = step(0, h, x, p, ca.SX(0, 1), ca.repmat(u, 1, STAGES))
    old = ca.vertcat(*(group.vector() for group in groups.values()))
    groups_of = (block.y.only(outputs), block.dx.only(block.x))
    y, dx = (ca.substitute(group.vector(), old, ca.vertcat(x, u, p)) for group in groups_of)
    return (
        ca.Function("step", [h, x, u, p], [after, ca.jacobian(after, x)]),
        ca.Function("outputs", [x, u, p], [ca.jacobian(y, x)]),
        ca.Function("slope", [x, u, p], [ca.jacobian(dx, x)]),
    )
