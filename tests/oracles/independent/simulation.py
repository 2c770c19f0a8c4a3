"""Simulations: fixed-step RK4, all seeds at once, and DOP853."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from .model import Model
from .noise import sensor_noise
from .parameters import Parameters, value
from .run import Run, run_of
from .signals import Signal, pulses
from .states import Array


def simulate(
    parameters: Parameters,
    *,
    method: str = "rk4",
    seeds: Sequence[int] = (0,),
    start: Array | None = None,
    reference: Signal | None = None,
    uncertainty: Signal | None = None,
    activations: Signal | None = None,
    grid: Array | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
) -> Run:
    """Fixed-step RK4 (all steps are returned, all seeds at once) or DOP853 on `grid` (noise-free)."""
    model = Model(parameters, reference, uncertainty, activations)
    X0 = np.asarray(model.start() if start is None else start, float).reshape(31, -1)
    X0 = np.repeat(X0, len(seeds), axis=1) if X0.shape[1] == 1 else X0
    with np.errstate(all="ignore"):
        return _rk4(model, X0, seeds) if method == "rk4" else _dop853(model, X0, grid, rtol, atol)


def _rk4(model: Model, X: Array, seeds: Sequence[int]) -> Run:
    p = model.p
    h, T_s = value(p, "step"), value(p, "noise.period")
    steps, hold = round(value(p, "duration") / h), round(T_s / h)
    if abs(hold * h - T_s) > 1e-9 * T_s or hold < 1:
        raise ValueError(f"the noise's period {T_s} is not a whole number of steps {h}")
    noise = sensor_noise(p, seeds, steps // hold + 1)
    pulse = pulses(p, h, np.arange(steps + 1))
    out = np.empty((31, steps + 1, X.shape[1]))
    out[:, 0] = X
    for i in range(steps):
        t, w, q = i * h, noise[i // hold], pulse[i]
        # k₁ = F(τ, X), k₂ = F(τ + h/2, X + h/2 k₁), k₃ = F(τ + h/2, X + h/2 k₂), k₄ = F(τ + h, X + h k₃)
        k1 = model.rhs(t, X, w, q)
        k2 = model.rhs(t + h / 2, X + h / 2 * k1, w, q)
        k3 = model.rhs(t + h / 2, X + h / 2 * k2, w, q)
        k4 = model.rhs(t + h, X + h * k3, w, q)
        # X⁺ = X + h/6 (k₁ + 2k₂ + 2k₃ + k₄)
        X = X + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        out[:, i + 1] = X
    index = np.arange(steps + 1)
    return run_of(model, index * h, out, noise[index // hold].transpose(1, 0, 2), pulse)


def _dop853(model: Model, X0: Array, grid: Array | None, rtol: float, atol: float) -> Run:
    p = model.p
    if value(p, "noise.x1") or value(p, "noise.force"):
        raise ValueError("the adaptive step is for noise-free runs")
    T, h = value(p, "duration"), value(p, "step")
    t = np.linspace(0, T, round(T / value(p, "record")) + 1) if grid is None else np.asarray(grid, float)
    drift = np.array([[0.0], [1.0], [1.0]]) * value(p, "noise.drift")
    jumps = {round(float(e) / h) * h for n in ("start", "stop") for e in np.atleast_1d(value(p, f"pulse.{n}"))}
    edges = sorted({0.0, T, *(e for e in jumps if 0 < e < T)})
    out, X = np.empty((31, t.size, 1)), X0[:, 0]
    for a, b in pairwise(edges):
        q, here = pulses(p, h, round(a / h)), (t >= a) & (t <= b)
        stops = np.union1d(t[here], b)
        s = solve_ivp(
            lambda tau, X, q=q: model.rhs(tau, X[:, None], drift, q)[:, 0], (a, b), X,
            method="DOP853", rtol=rtol, atol=atol, max_step=0.005, t_eval=stops,
        )  # fmt: skip
        out[:, here, 0], X = s.y[:, : here.sum()], s.y[:, -1]
    return run_of(model, t, out, drift[:, None], pulses(p, h, np.floor(t / h + 1e-9)))
