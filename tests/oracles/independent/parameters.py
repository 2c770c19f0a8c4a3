"""Parameters, a flat dict of paths, e.g. {"plant.m": 1.1, "high_gain.m": 1.0, "muscle1.k": 17.0}.

What is not given keeps the paper's value.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from .states import Array

Parameters = Mapping[str, Any]

PAPER: dict[str, Any] = {
    "plant.m": 1.0, "plant.C": 5.54, "plant.drive": "virtual", "plant.a_min": 0.01,
    "muscle.W": 0.3, "muscle.A_hill": 0.25, "muscle.g_max": 1.5,
    "muscle.L_slack": 2.0, "muscle.toe": 0.04, "muscle.F_toe": 0.5, "muscle.k": 19.2308,
    "reference.offset": 2.6315, "reference.amplitude": 0.01, "reference.frequency": 0.5,
    "uncertainty.offset": 0.005, "uncertainty.amplitude": 0.005, "uncertainty.frequency": 0.8,
    "controller.gamma": 1.0, "controller.q": 10.0, "controller.R": 30.0,
    "controller.k_c": 0.0, "controller.F_c": 0.2, "controller.u_max": 0.9, "controller.Delta_min": 0.1,
    "noise.x1": 0.0, "noise.force": 0.0, "noise.drift": 0.0, "noise.period": 0.005,
    "pulse.amplitude": (), "pulse.start": (), "pulse.stop": (),
    "activation1.offset": 0.35, "activation1.amplitude": 0.1, "activation1.frequency": 1.0,
    "activation2.offset": 0.35, "activation2.amplitude": -0.1, "activation2.frequency": 1.0,
    "high_gain.eps_h": 0.1, "high_gain.h11": 3.0, "high_gain.h12": 3.0, "high_gain.h13": 1.0,
    "high_gain.h21": 2.0, "high_gain.h22": 1.0, "high_gain.h31": 2.0, "high_gain.h32": 1.0,
    "sliding_mode.alpha11": 1.1, "sliding_mode.lambda11": 28.17, "sliding_mode.alpha2": 1.1,
    "sliding_mode.alpha3": 1.0, "sliding_mode.tau_s": 0.01, "sliding_mode.delta_s": 0.01,
    "adaptive_sliding_mode.alpha0": 2 * np.sqrt(2 * 1.1), "adaptive_sliding_mode.beta0": 1.1,
    "adaptive_sliding_mode.eta1": 0.2, "adaptive_sliding_mode.eta2": 0.2, "adaptive_sliding_mode.a_dual": 0.82,
    "adaptive_sliding_mode.l0": 0.4, "adaptive_sliding_mode.r00": 0.4,
    "adaptive_sliding_mode.r01": 0.5, "adaptive_sliding_mode.r02": 0.5, "adaptive_sliding_mode.tau_a": 0.01,
    "adaptive_sliding_mode.eps_a0": 0.2, "adaptive_sliding_mode.eps_a1": 0.2, "adaptive_sliding_mode.eps_a2": 0.2,
    "adaptive_sliding_mode.alpha_a1": 0.99, "adaptive_sliding_mode.alpha_a2": 0.99,
    "adaptive_sliding_mode.gamma_a0": 200.0, "adaptive_sliding_mode.gamma_a1": 300.0,
    "adaptive_sliding_mode.gamma_a2": 300.0, "adaptive_sliding_mode.delta00": 0.001,
    "adaptive_sliding_mode.delta01": 0.001, "adaptive_sliding_mode.delta02": 0.001,
    "adaptive_sliding_mode.delta_a": 0.01, "adaptive_sliding_mode.L_min": 0.05,
    "adaptive_sliding_mode.k_max": 10.0, "adaptive_sliding_mode.r_max": 20.0, "adaptive_sliding_mode.leak": 0.0,
    "initial.x1": 2.60, "initial.x2": 0.0, "initial.x3": 2.018, "initial.x4": 2.018,
    "initial.x1_hat": 2.62, "initial.x2_hat": 0.0, "initial.x3_hat": 2.01, "initial.x4_hat": 2.01,
    "duration": 20.0, "step": 5e-4, "record": 0.01, "score.start": 2.0,
}  # fmt: skip

NOISE = {"noise.x1": 0.001, "noise.force": 0.001, "noise.drift": 0.001}
CHALLENGE = {
    **NOISE, "controller.k_c": 5.0, "reference.offset": 2.77, "reference.amplitude": 0.05, "reference.frequency": 2.0,
    "uncertainty.offset": 0.01, "uncertainty.amplitude": 0.03, "uncertainty.frequency": 1.3, "initial.x1": 2.75,
    "initial.x2": 0.1, "initial.x3": 2.0225, "initial.x4": 2.0225, "initial.x1_hat": 2.77,
}  # fmt: skip
SCENARIOS: dict[str, dict[str, Any]] = {
    "paper-clean": {},
    "paper-noisy": NOISE,
    "challenge": CHALLENGE,
    "slack": {**NOISE, "pulse.amplitude": (-0.065, 0.065), "pulse.start": (5.0, 7.0), "pulse.stop": (6.0, 8.0)},
    "slack-deep": {**CHALLENGE, "controller.k_c": 0.0, "reference.frequency": 1.0},
}  # fmt: skip


def value(p: Parameters, path: str, consumer: str = "") -> Any:
    """The consumer's own value if it has one, else the tied one; `plant.m` and `muscle.W` are the tied names."""
    name = path.split(".")[-1]
    group = path.split(".")[0]
    candidates = [path]
    if group[:6] == "muscle":
        candidates = [f"{group}.{name}", f"muscle.{name}"]
        if consumer:
            candidates = [f"{consumer}.{group}.{name}", f"{consumer}.muscle.{name}", f"{consumer}.{name}", *candidates]
    elif consumer:
        candidates = [f"{consumer}.{name}", path]
    for source in (p, PAPER):
        for candidate in candidates:
            if candidate in source:
                return source[candidate]
    raise KeyError(path)


def gains(p: Parameters, observer: str) -> dict[str, Any]:
    """All gains of one observer, by their names alone."""
    return {path.split(".")[1]: value(p, path) for path in PAPER if path.startswith(observer + ".")}


def column(numbers: Mapping[str, Any], *names: str) -> Array:
    """Numbers one below the other, for arrays with the muscles on the first axis."""
    return np.array([[numbers[name]] for name in names])
