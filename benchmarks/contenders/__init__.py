"""Who takes part: one module per way of simulating the loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from hillobs.codegen.cache import BuildError
from hillobs.model.arrays import Array

from ..problem import Problem, noise
from ..roofline import Work

# rounding apart
_SAME = 1e-9


class AbsentError(RuntimeError):
    """What a contender needs is not here; the sentence says what."""


@dataclass(frozen=True)
class Contender:
    """One row of the table.

    work: simulates `runs` × `steps` closed-loop steps with noise; final: the 31 states after `steps` steps without.
    tolerance: how far these may be from our kernel's, which takes the same RK4 steps. operations: what one step of ours
    takes. reference: the short name of one that all are compared with.
    """

    name: str
    runs: int
    steps: int
    work: Callable[[], object]
    final: Callable[[], Array]
    tolerance: float = _SAME
    operations: Work | None = None
    reference: str = ""


def marching(
    name: str,
    of: Problem,
    runs: int,
    steps: int,
    march: Callable[[Array], Array],
    tolerance: float = _SAME,
    reference: str = "",
) -> Contender:
    """A contender whose `march` takes noise (samples × channels × runs) and returns the states, 31 × runs."""
    samples = noise(of, runs, steps)

    def final() -> Array:
        return np.asarray(march(np.zeros_like(samples)))[:, -1]

    return Contender(name, runs, steps, lambda: march(samples), final, tolerance, reference=reference)


Builder = Callable[[Problem], Contender]


def builders() -> Iterator[Builder]:
    """All contenders, ours first, each built when it is its turn."""
    from . import casadi_vm, jax_scan, numba_loops, numpy_batch, ours, plain_c, scipy_ivp

    yield from ours.variants()
    yield from (plain_c.exported, plain_c.shared)
    yield from (casadi_vm.as_written, casadi_vm.lean)
    yield from (numba_loops.abreast, numba_loops.one_by_one, jax_scan.scan, numpy_batch.batch)
    yield from (scipy_ivp.rk45, scipy_ivp.lsoda)


def contenders(of: Problem, absent: Callable[[str], None]) -> Iterator[Contender]:
    """Those that can take part here; `absent` is told why another cannot."""
    for build in builders():
        try:
            yield build(of)
        except (AbsentError, BuildError) as error:
            absent(str(error))
