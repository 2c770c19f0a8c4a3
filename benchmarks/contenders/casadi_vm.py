"""CasADi's own virtual machine, a whole run in one call: `mapaccum` over an RK4 step."""

from __future__ import annotations

import casadi as ca
import numpy as np

from hillobs.model.arrays import Array

from ..lean import lean_step
from ..problem import Problem, right_hand_side
from . import Contender, marching

_STEPS = 400


def as_written(of: Problem) -> Contender:
    """The wired Block as it stands, in four stages."""
    f, numbers = right_hand_side(of)
    h = of.grid.h
    t, x, w = (ca.MX.sym(name, *f.size_in(name)) for name in ("t", "x", "w"))
    k1 = f(t, x, numbers, w)
    k2 = f(t + h / 2, x + h / 2 * k1, numbers, w)
    k3 = f(t + h / 2, x + h / 2 * k2, numbers, w)
    k4 = f(t + h, x + h * k3, numbers, w)
    step = ca.Function("step", [x, t, w], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])
    return _contender("CasADi mapaccum, as written", of, step, of.times(_STEPS)[:, None])


def lean(of: Problem) -> Contender:
    """The lean step."""
    made = lean_step(of)
    f = made.function
    c, x, w = (ca.SX.sym(name, *f.size_in(name)) for name in f.name_in())
    step = ca.Function("step", [x, c, w], [f(c, x, w)])
    return _contender("CasADi mapaccum, lean step", of, step, made.table(of.times(_STEPS)))


def _contender(name: str, of: Problem, step: ca.Function, times: Array) -> Contender:
    whole = step.mapaccum(_STEPS)

    def march(samples: Array) -> Array:
        held = np.repeat(samples[:, :, 0], of.grid.hold, axis=0)[:_STEPS]
        return np.array(whole(of.x0, times.T, held.T))

    return marching(name, of, 1, _STEPS, march)
