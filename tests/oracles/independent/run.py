"""Trajectories: states over time, and the inputs, activations and estimates that follow from them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from .model import Model
from .muscle import Phi_S, activation
from .states import OBSERVERS, STATES, Array


@dataclass
class Run:
    """Trajectories: the last axis is the run (seed), the one before it time."""

    p: dict[str, Any]
    t: Array
    states: Array  # (31, n_t, n)
    u: Array  # (2, n_t, n), the plant's, with the pulse
    Delta: Array  # (n_t,)
    a: Array  # (2, n_t, n), the formula on the true (x, u)
    a_in: Array  # the activation put in, NaN for the virtual drive
    flags: Array  # (4, 2, n_t, n): a below a_min, a above 1, z below 0, z above 1.45
    y: Array  # (3, n_t, n), as the observers see it
    estimates: dict[str, Array]  # (9, n_t, n) in the order of QUANTITIES, a limited
    limited: dict[str, Array]  # (2, 2, n_t, n): û outside [−5, 0.95], â outside [0, 1]
    truth: Array  # (9, n_t, n)
    slack: Array  # (2, n_t, n): Φ_S = 0
    model: Model

    def state(self, name: str) -> Array:
        return self.states[STATES.index(name)]


def run_of(model: Model, t: Array, X: Array, noise: Array, pulse: Array) -> Run:
    """What follows from the states: u, Δ, a and the estimates."""
    shape = X.shape[1:]
    flat = X.reshape(31, -1)
    tt, qq = np.repeat(t, shape[1]), np.repeat(np.broadcast_to(pulse, t.shape), shape[1])
    c = model.curves["plant"]
    u, a_in, flags = model.drives(tt, flat[:4], qq)
    a = activation(flat[0], flat[2:4], u, model.C["plant"], c)
    D = np.broadcast_to(np.asarray(model.uncertainty(t)[0], float), t.shape)
    estimates, limited = {}, {}
    for i, name in enumerate(OBSERVERS):
        o = 4 + 7 * i
        u_hat = flat[o + 4 : o + 7 : 2]
        # û limited to [−5, 0.95] before g, â projected to [0, 1]
        raw = activation(flat[o], flat[o + 3 : o + 7 : 2], np.clip(u_hat, -5, 0.95), model.C[name], model.curves[name])
        parts = (flat[o : o + 2], flat[o + 3 : o + 7 : 2], flat[o + 2 : o + 3], u_hat, np.clip(raw, 0, 1))
        estimates[name] = np.concatenate(parts).reshape(9, *shape)
        limited[name] = np.stack([(u_hat < -5) | (u_hat > 0.95), (raw < 0) | (raw > 1)]).reshape(2, 2, *shape)
    y = np.concatenate([flat[:1], Phi_S(flat[2:4], c)]).reshape(3, *shape) + noise
    u, a, a_in = (v.reshape(2, *shape) for v in (u, a, a_in))
    truth = np.concatenate([X[:4], np.broadcast_to(D[:, None], shape)[None], u, a])
    slack = (Phi_S(flat[2:4], c) == 0).reshape(2, *shape)
    return Run(model.p, t, X, u, D, a, a_in, flags.reshape(4, 2, *shape), y, estimates, limited, truth, slack, model)
