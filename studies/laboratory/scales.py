"""The dimensionless form of the paper from what is in SI, and its results back in SI.

The reference values are those of muscle 1, the first of a mechanism: F₀ its largest force, l₀ its optimal fibre length,
v₀ its largest velocity in optimal fibre lengths per second. Lengths are in l₀, forces in F₀, velocities in l₀v₀, masses
in F₀/(l₀v₀²), angles in rad, and time is τ = v₀t.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...model.arrays import Array
from ...model.curves.sizes import relative
from ...model.skeleton.tree import SLIDER
from ...model.symbols import MUSCLES
from ..files.errors import ScenarioError
from .mechanisms.mechanism import Mechanism
from .muscles import Muscle, MusclePair


@dataclass(frozen=True)
class Scales:
    """F₀ N, l₀ m, v₀ 1/s, and `numbers`: path → value of what is dimensionless, as scenarios have it.

    sliding: of each joint, whether its coordinate is a length; else it is an angle.
    """

    force: float
    length: float
    rate: float
    numbers: Mapping[str, float]
    sliding: Sequence[bool] = (True,)

    @property
    def mass(self) -> float:
        """Unit of mass in kg."""
        return self.force / (self.length * self.rate**2)

    @property
    def coordinates(self) -> Array:
        """Units of the joints' coordinates, m or rad."""
        return np.where(self.sliding, self.length, 1.0)

    @property
    def torques(self) -> Array:
        """Units of what moves each joint, N or N m."""
        return self.force * self.length / self.coordinates

    # into the paper's variables

    def tau(self, time: Array) -> Array:
        """Dimensionless time of s."""
        # τ = v₀t
        return self.rate * time

    def lengths(self, metres: Array) -> Array:
        """L_S or L_C of m."""
        return metres / self.length

    def forces(self, newtons: Array) -> Array:
        """y₂, y₃ of N."""
        # Φ_Sj = force_j/F₀
        return newtons / self.force

    # and back

    def metres(self, lengths: Array) -> Array:
        """Tendon or fibre length in m."""
        return lengths * self.length

    def velocity(self, rates: Array) -> Array:
        """Rate of a length in m/s."""
        # velocity = l₀v₀x₂
        return rates * self.length * self.rate

    def fibre_velocity(self, u: Array) -> Array:
        """Fibre velocity in m/s, positive when the fibre lengthens."""
        # fibre velocity_j = −l₀v₀u_j
        return 0.0 - u * self.length * self.rate

    def positions(self, q: Array) -> Array:
        """Coordinates (… × joints) in m or rad."""
        return q * self.coordinates

    def velocities(self, dq: Array) -> Array:
        """Their rates in m/s or rad/s."""
        return dq * self.coordinates * self.rate


def scales(pair: MusclePair) -> Scales:
    """Reference values and dimensionless numbers of a pair.

    ScenarioError if a muscle 2 of other size has curves that only the reference muscle can have.
    """
    first = pair.muscle1
    force, length, rate = first.F_max, first.optimal_fibre_length, first.v_max
    # m = mass l₀v₀²/F₀,  C = C/l₀
    numbers = {"plant.m": pair.mass * length * rate**2 / force, "plant.C": pair.C / length}
    muscles = dict(zip(MUSCLES, (pair.muscle1, pair.muscle2), strict=True))
    return Scales(force, length, rate, {**numbers, **_numbers(muscles)})


def mechanism_scales(mechanism: Mechanism) -> Scales:
    """The same of a mechanism."""
    first = next(iter(mechanism.muscles.values()))
    sliding = [mechanism.tree.joints[name].kind == SLIDER for name in mechanism.tree.coordinates]
    return Scales(first.F_max, first.optimal_fibre_length, first.v_max, _numbers(mechanism.muscles), tuple(sliding))


def _numbers(muscles: Mapping[str, Muscle]) -> dict[str, float]:
    """`BRA.L_slack` … for the numbers of all muscles."""
    reference = next(iter(muscles))
    return {
        f"{name}.{key}": value
        for name, muscle in muscles.items()
        for key, value in curve_numbers(name, muscle, reference, muscles[reference]).items()
    }


def curve_numbers(name: str, muscle: Muscle, reference: str, first: Muscle) -> dict[str, float]:
    """The numbers of a muscle's curve set, its sizes in those of the first."""
    curves = muscle.curves
    sizes = relative(muscle.sizes, first.sizes)
    unlike = [key for key in sizes if key not in curves.parameters and sizes[key] != 1]
    if unlike:
        raise ScenarioError(
            f"{name}: curves {curves.name} have no size of their own: {', '.join(unlike)} must be that of {reference}"
        )
    numbers = {key: {**muscle.numbers, **sizes}[key] for key in curves.parameters}
    if objection := curves.objection({key: numbers[key] for key in curves.tendon}):
        raise ScenarioError(f"{name}: {objection}")
    return {**numbers, **({"pennation": muscle.pennation} if muscle.pennation else {})}
