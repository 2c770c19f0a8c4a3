"""numba: one run after the other, and many abreast in a loop that LLVM turns into vector instructions."""

from __future__ import annotations

import os
import platform
from types import ModuleType
from typing import Any

import numpy as np

from hillobs.model.arrays import Array

from ..emit import NUMBERS, in_loop, python
from ..lean import lean_step
from ..problem import Problem
from . import Contender, marching
from .optional import imported

_RUNS, _STEPS = 64, 2_000
# no run-time check of divisions, sums in any order: what makes it fastest
_OPTIONS = {"fastmath": True, "error_model": "numpy"}


def abreast(of: Problem) -> Contender:
    """The lean step in an inner loop over runs."""
    numba, lean = _numba(), lean_step(of)
    step = numba.njit(**_OPTIONS)(in_loop(lean.function, _RUNS, ("x", "w"), "x"))
    clock, hold = lean.table(of.times(_STEPS)), of.grid.hold

    def loop(x: Array, clock: Array, noise: Array) -> None:
        for k in range(len(clock)):
            step(clock[k], x, noise[k // hold])

    compiled = numba.njit(**_OPTIONS)(loop)

    def march(samples: Array) -> Array:
        x = np.repeat(of.x0, _RUNS)
        compiled(x, clock, samples.reshape(len(samples), -1))
        return x.reshape(-1, _RUNS)

    return marching(f"numba, {_RUNS} runs abreast, lean step", of, _RUNS, _STEPS, march, reference="numba")


def one_by_one(of: Problem) -> Contender:
    """The lean step, one run."""
    numba, lean = _numba(), lean_step(of)
    step = numba.njit(**_OPTIONS)(python(lean.function, NUMBERS))
    clock, hold = lean.table(of.times(_STEPS)), of.grid.hold

    def loop(x: Array, clock: Array, noise: Array) -> None:
        for k in range(len(clock)):
            (after,) = step(clock[k], x, noise[k // hold])
            for i, value in enumerate(after):
                x[i] = value

    compiled = numba.njit(**_OPTIONS)(loop)

    def march(samples: Array) -> Array:
        x = of.x0.copy()
        compiled(x, clock, np.ascontiguousarray(samples[:, :, 0]))
        return x[:, None]

    return marching("numba, run by run, lean step", of, 1, _STEPS, march)


def _numba() -> Any:  # noqa: ANN401  it has no types
    if platform.machine() == "x86_64" and "NUMBA_CPU_FEATURES" not in os.environ:
        # the widest registers, as for our own kernel: LLVM would rather use half of them
        binding: ModuleType = imported("llvmlite.binding", "numba")
        os.environ["NUMBA_CPU_NAME"] = binding.get_host_cpu_name()
        os.environ["NUMBA_CPU_FEATURES"] = f"{binding.get_host_cpu_features().flatten()},-prefer-256-bit"
    return imported("numba")
