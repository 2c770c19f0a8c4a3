"""What the estimates of a sample are in SI, alike for recordings and for samples that come live."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable

import casadi as ca
import numpy as np

from ...model.arrays import Array
from ...model.block import symbols
from ..laboratory.laws import mapped
from ..laboratory.subject import Subject

OF_JOINTS = ("position", "velocity", "disturbance")
OF_MUSCLES = ("tendon_length", "fibre_length", "fibre_velocity", "activation")
# samples at a time: a few MB
_PIECE = 16_384


class Quantities:
    """What leads from the estimates of a subject, dimensionless as `System.quantities` has them, to SI."""

    def __init__(self, subject: Subject) -> None:
        system = subject.system
        self._scales, self._heights = subject.scales, subject.heights
        self._oblique = bool(self._heights.any())
        sizes = [len(system.joints)] * len(OF_JOINTS) + [len(system.muscles)] * len(OF_MUSCLES)
        ends = np.cumsum([0, *sizes]).tolist()
        self._places = [slice(*ends) for ends in itertools.pairwise(ends)]
        self._function = _function(subject)

    def __call__(self, estimates: Array) -> dict[str, Array]:
        """Quantity → (… × joints or muscles) of estimates (… × quantities)."""
        flat = estimates.reshape(-1, estimates.shape[-1])
        pieces = [mapped(self._function, [flat[i : i + _PIECE]]) for i in range(0, len(flat), _PIECE)]
        return self._in_SI(np.concatenate(pieces).reshape(*estimates.shape[:-1], -1))

    def of_memory(self, estimates: Array) -> Callable[[], dict[str, Array]]:
        """The same of the estimates (quantities) that are in this memory whenever it is called."""
        told = np.empty(self._places[-1].stop)
        buffer, evaluate = self._function.buffer()
        buffer.set_arg(0, memoryview(estimates))
        buffer.set_res(0, memoryview(told))

        def in_SI(kept: ca.FunctionBuffer) -> dict[str, Array]:
            evaluate()
            return self._in_SI(told)

        # `evaluate` does not keep its buffer alive
        return functools.partial(in_SI, buffer)

    def _in_SI(self, told: Array) -> dict[str, Array]:
        s = self._scales
        q, dq, forces, L_S, L, u, a = [told[..., place] for place in self._places]
        L_C, v_C = s.metres(L), s.fibre_velocity(u)
        if self._oblique:
            L_C, along = _fibres(L_C, self._heights)
            v_C = v_C * along
        return {
            "position": s.positions(q),
            "velocity": s.velocities(dq),
            "disturbance": s.loads(forces),
            "tendon_length": s.metres(L_S),
            "fibre_length": L_C,
            "fibre_velocity": v_C,
            "activation": a,
        }


@functools.lru_cache(maxsize=8)
def quantities_of(subject: Subject) -> Quantities:
    """What leads to the SI of a subject, written down once."""
    return Quantities(subject)


def _function(subject: Subject) -> ca.Function:
    """What is to be scaled, by joint or muscle: q, q̇, forces, L_S, L_m − L_S, u, a."""
    system, p = subject.system, subject.laws.p
    estimates = symbols(system.quantities)
    q, dq, Delta, L_S, u, a = (
        [estimates[name] for name in names]
        for names in (*map(system.joint, ("q", "dq", "Delta")), *map(system.muscle, ("L_S", "u", "a")))
    )
    rest = [L_m - length for L_m, length in zip(system.lengths(q, p), L_S, strict=True)]
    told = [*q, *dq, *system.forces(q, Delta, p), *L_S, *rest, *u, *a]
    return ca.Function("quantities", [estimates.vector()], [ca.densify(ca.vertcat(*told))])


def _fibres(L: Array, heights: Array) -> tuple[Array, Array]:
    """Lengths of fibres that reach L along the tendon, and the cosines of their angles to it."""
    # L_C cos α = L_m − L_S,  L_C sin α = h
    oblique = np.hypot(L, heights)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(heights > 0, oblique, L), np.where(heights > 0, L / oblique, 1.0)
