"""JAX: `lax.scan` over holds and steps, `vmap` over runs, 64 bits, compiled by XLA."""

from __future__ import annotations

from typing import Any

import numpy as np

from hillobs.model.arrays import Array

from ..emit import JAX, python
from ..lean import lean_rates
from ..problem import Problem
from . import Contender, marching
from .optional import imported

Traced = Any  # JAX's arrays while it writes down what is done with them

_RUNS, _STEPS = 512, 400
# the widest registers, and the order of operations that keeps them in the nearest cache
_OPTIONS = {"xla_cpu_prefer_vector_width": 512, "xla_cpu_enable_concurrency_optimized_scheduler": False}


def scan(of: Problem) -> Contender:
    """Four lean right-hand sides: XLA runs the lean step, written as one, no faster."""
    jax, jnp = imported("jax"), imported("jax.numpy")
    jax.config.update("jax_enable_x64", True)
    lean, h, hold = lean_rates(of), of.grid.h, of.grid.hold
    emitted = python(lean.function, JAX)
    halves = lean.table(np.arange(2 * _STEPS + 1) * h / 2)
    # c at the start, the middle and the end of each step
    clock = np.stack([halves[:-1:2], halves[1::2], halves[2::2]], axis=1).reshape(_STEPS // hold, hold, 3, -1)

    def rates(c: Traced, x: Traced, w: Traced) -> Traced:
        return jnp.stack(emitted(c, x, w)[0])

    def run(noise: Traced) -> Traced:
        def of_a_hold(x: Traced, given: Traced) -> tuple[Traced, None]:
            times, w = given

            def step(x: Traced, c: Traced) -> tuple[Traced, None]:
                k1 = rates(c[0], x, w)
                k2 = rates(c[1], x + h / 2 * k1, w)
                k3 = rates(c[1], x + h / 2 * k2, w)
                k4 = rates(c[2], x + h * k3, w)
                return x + h / 6 * (k1 + 2 * (k2 + k3) + k4), None

            return jax.lax.scan(step, x, times)[0], None

        return jax.lax.scan(of_a_hold, jnp.asarray(of.x0), (jnp.asarray(clock), noise))[0]

    shape = jax.ShapeDtypeStruct((len(clock), len(of.loop.noise), _RUNS), np.float64)
    traced = jax.jit(jax.vmap(run, in_axes=2, out_axes=1)).lower(shape)
    compiled = traced.compile(compiler_options=_OPTIONS)

    def march(samples: Array) -> Array:
        return np.asarray(compiled(samples))

    return marching(f"JAX scan + vmap, {_RUNS} runs abreast, lean", of, _RUNS, _STEPS, march, reference="JAX")
