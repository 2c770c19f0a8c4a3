"""NumPy: every number an array over runs."""

from __future__ import annotations

import numpy as np

from hillobs.model.arrays import Array

from ..emit import NUMPY, python
from ..lean import lean_step
from ..problem import Problem
from . import Contender, marching

_RUNS, _STEPS = 4096, 100


def batch(of: Problem, runs: int = _RUNS) -> Contender:
    """The lean step; so many runs fill the caches and hide the interpreter."""
    lean = lean_step(of)
    step, clock = python(lean.function, NUMPY), lean.table(of.times(_STEPS)).tolist()

    def march(samples: Array) -> Array:
        x = [np.full(runs, value) for value in of.x0]
        for k, c in enumerate(clock):
            (x,) = step(c, x, samples[k // of.grid.hold])
        return np.array(x)

    return marching(f"NumPy, {runs} runs abreast, lean step", of, runs, _STEPS, march)
