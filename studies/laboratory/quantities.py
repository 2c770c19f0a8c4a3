"""What the quantities of a system are in SI, alike for recordings, samples that come live, and runs."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from ...model.arrays import Array
from ...model.block import symbols
from .subject import Subject, oblique

OF_JOINTS = ("position", "velocity", "disturbance")
OF_MUSCLES = ("tendon_length", "fibre_length", "fibre_velocity", "activation")
# units of what slides and of what turns
_UNITS_OF_JOINTS: Mapping[str, tuple[str, str]] = {
    "position": ("m", "rad"),
    "velocity": ("m/s", "rad/s"),
    "acceleration": ("m/s2", "rad/s2"),
    "disturbance": ("N", "N m"),
}
# between the two, where some joints slide and some turn
OR = " or "
UNITS_OF_MUSCLES: Mapping[str, str] = {
    "force": "N",
    "path_length": "m",
    "tendon_length": "m",
    "fibre_length": "m",
    "fibre_velocity": "m/s",
    "activation": "1",
    "excitation": "1",
}
# samples at a time: a few MB
_PIECE = 16_384


def unit_of_joints(sliding: Sequence[bool], quantity: str) -> str:
    """The unit of a quantity of joints, or both if some slide and some turn."""
    slides, turns = _UNITS_OF_JOINTS[quantity]
    return slides if all(sliding) else f"{slides}{OR}{turns}" if any(sliding) else turns


class Quantities:
    """What leads from the estimates of a subject, dimensionless as `System.quantities` has them, to SI.

    places: quantity → where the numbers of its joints or muscles are among those in SI.
    """

    def __init__(self, subject: Subject) -> None:
        system, s = subject.system, subject.scales
        sizes = {**dict.fromkeys(OF_JOINTS, len(system.joints)), **dict.fromkeys(OF_MUSCLES, len(system.muscles))}
        ends = itertools.accumulate(sizes.values(), initial=0)
        self.places = {name: slice(*pair) for name, pair in zip(sizes, itertools.pairwise(ends), strict=True)}
        self._size = sum(sizes.values())
        self._scales = np.array([s.force, s.length, s.rate, *s.coordinates, *s.torques])
        self._function = _function(subject)

    def __call__(self, estimates: Array) -> dict[str, Array]:
        """Quantity → (… × joints or muscles) of estimates (… × quantities)."""
        flat = np.ascontiguousarray(estimates.reshape(-1, estimates.shape[-1]))
        found = np.empty((len(flat), self._size))
        for start in range(0, len(flat), _PIECE):
            self._evaluation(flat[start : start + _PIECE], found[start : start + _PIECE])()
        told = _signless(found).reshape(*estimates.shape[:-1], self._size)
        return {name: told[..., place] for name, place in self.places.items()}

    def of_memory(self, estimates: Array) -> Callable[[], list[float]]:
        """All numbers in SI of the estimates (quantities) that are in this memory whenever it is called."""
        told = np.empty((1, self._size))
        evaluate = self._evaluation(estimates[None], told)

        def numbers() -> list[float]:
            evaluate()
            found: list[float] = _signless(told[0]).tolist()
            return found

        return numbers

    def _evaluation(self, estimates: Array, told: Array) -> Callable[[], None]:
        """Write what estimates (n × quantities) are in SI into `told` (n × numbers), both as they lie in memory."""
        buffer: Any
        # the scales are those of all samples
        buffer, evaluate = self._function.map("quantities", "serial", len(estimates), [1], []).buffer()
        for i, values in enumerate((estimates, self._scales)):
            buffer.set_arg(i, values.data)
        buffer.set_res(0, told.data)
        # `evaluate` alone would not keep its buffer alive
        return functools.partial(_evaluated, evaluate, buffer)


def _evaluated(evaluate: Callable[[], object], buffer: object) -> None:
    evaluate()


@functools.lru_cache(maxsize=8)
def quantities_of(subject: Subject) -> Quantities:
    """What leads to the SI of a subject, written down once."""
    return Quantities(subject)


def _signless(values: Array) -> Array:
    """Without −0: what rests has no direction."""
    return values + 0.0


def _function(subject: Subject) -> ca.Function:
    """Of estimates and scales; these are symbols, since CasADi would multiply constants first."""
    system, p = subject.system, subject.laws.p
    given = ca.SX.sym("scales", 3 + 2 * len(system.joints))
    force, length, rate, coordinates, torques = ca.vertsplit(given, np.cumsum([0, 1, 1, 1, *[len(system.joints)] * 2]))
    scales: Any = {"force": force, "length": length, "rate": rate, "coordinates": coordinates, "torques": torques}
    s: Any = replace(subject.scales, **scales)
    estimates = symbols(system.quantities)
    q, dq, Delta, L_S, u, a = (
        ca.vertcat(*(estimates[name] for name in names))
        for names in (*map(system.joint, ("q", "dq", "Delta")), *map(system.muscle, ("L_S", "u", "a")))
    )
    L_m = ca.vertcat(*system.lengths(ca.vertsplit(q), p))
    L_C, along = oblique(s.metres(L_m - L_S), subject.heights)
    told = {
        "position": s.positions(q),
        "velocity": s.velocities(dq),
        "disturbance": s.loads(ca.vertcat(*system.forces(ca.vertsplit(q), ca.vertsplit(Delta), p))),
        "tendon_length": s.metres(L_S),
        "fibre_length": L_C,
        "fibre_velocity": s.fibre_velocity(u) * along,
        "activation": a,
    }
    all_of = ca.vertcat(*(told[name] for name in (*OF_JOINTS, *OF_MUSCLES)))
    return ca.Function("quantities", [estimates.vector(), given], [ca.densify(all_of)])
