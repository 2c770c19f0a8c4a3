"""Levant's differentiators as they are printed, by powers and signs, about a smoothed sign; RK4 by hand."""

from collections.abc import Callable

import numpy as np

from .states import Array

# λ_i of order n, non-recursive, i = 0 … n
LAMBDA = {1: (1.5, 1.1), 2: (2.0, 2.12, 1.1)}


def rates(z: Array, f: float, known: Array, L: float, eps: float) -> Array:
    """ż_i = z_{i+1} + known_i + λ_i L^((i+1)/(n+1)) |e|^((n−i)/(n+1)) s(e)^((i+1)/(n+1)), s the smoothed sign."""
    n = len(z) - 1
    e = f - z[0]
    smooth = abs(e) / (abs(e) + L * eps ** (n + 1))
    powers = (np.arange(n + 1) + 1) / (n + 1)
    injected = np.array(LAMBDA[n]) * L**powers * abs(e) ** (1 - powers) * smooth**powers * np.sign(e)
    return np.append(z[1:], 0) + known + injected


def follow(
    z: Array, f: Callable[[float], float], known: Callable[[float], Array], L: float, eps: float, h: float, steps: int
) -> Array:
    """(steps + 1, n + 1): z_i at the grid points."""
    path = [np.array(z, dtype=float)]
    for k in range(steps):
        t, z = k * h, path[-1]
        k1 = rates(z, f(t), known(t), L, eps)
        k2 = rates(z + h / 2 * k1, f(t + h / 2), known(t + h / 2), L, eps)
        k3 = rates(z + h / 2 * k2, f(t + h / 2), known(t + h / 2), L, eps)
        k4 = rates(z + h * k3, f(t + h), known(t + h), L, eps)
        path.append(z + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
    return np.array(path)
