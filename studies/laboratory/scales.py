"""The dimensionless form of the paper from a pair in SI, and its results back in SI.

The reference values are those of muscle 1: F₀ its largest force, l₀ its optimal fibre length, v₀ its largest velocity
in optimal fibre lengths per second. Lengths are in l₀, forces in F₀, velocities in l₀v₀, and time is τ = v₀t.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...model.arrays import Array
from ...model.curves.sizes import relative
from ...model.symbols import MUSCLES
from ..files.errors import ScenarioError
from .muscles import Muscle, MusclePair


@dataclass(frozen=True)
class Scales:
    """F₀ N, l₀ m, v₀ 1/s, the mass kg, and `numbers`: path → value of the dimensionless pair, as scenarios have it."""

    force: float
    length: float
    rate: float
    mass: float
    numbers: Mapping[str, float]

    # into the paper's variables

    def tau(self, time: Array) -> Array:
        """Dimensionless time of s."""
        # τ = v₀t
        return self.rate * time

    def lengths(self, metres: Array) -> Array:
        """y₁, L_S or L_C of m."""
        # x₁ = position/l₀
        return metres / self.length

    def forces(self, newtons: Array) -> Array:
        """y₂, y₃ of N."""
        # Φ_Sj = force_j/F₀
        return newtons / self.force

    # and back

    def metres(self, lengths: Array) -> Array:
        """Position, tendon or fibre length in m."""
        return lengths * self.length

    def velocity(self, x2: Array) -> Array:
        """Velocity of the mass in m/s."""
        # velocity = l₀v₀x₂
        return x2 * self.length * self.rate

    def fibre_velocity(self, u: Array) -> Array:
        """Fibre velocity in m/s, positive when the fibre lengthens."""
        # fibre velocity_j = −l₀v₀u_j
        return 0.0 - u * self.length * self.rate

    def disturbance(self, Delta: Array) -> Array:
        """External force on the mass in N, positive to the right."""
        # disturbance = mass l₀v₀² Δ_Φ
        return Delta * self.mass * self.length * self.rate**2


def scales(pair: MusclePair) -> Scales:
    """Reference values and dimensionless numbers of a pair.

    ScenarioError if a muscle 2 of other size has curves that only the reference muscle can have.
    """
    first = pair.muscle1
    force, length, rate = first.F_max, first.optimal_fibre_length, first.v_max
    # m = mass l₀v₀²/F₀,  C = C/l₀
    numbers = {"plant.m": pair.mass * length * rate**2 / force, "plant.C": pair.C / length}
    for name, muscle in zip(MUSCLES, (pair.muscle1, pair.muscle2), strict=True):
        numbers |= {f"{name}.{key}": value for key, value in _curve_numbers(name, muscle, first).items()}
    return Scales(force, length, rate, pair.mass, numbers)


def _curve_numbers(name: str, muscle: Muscle, first: Muscle) -> dict[str, float]:
    """The numbers of a muscle's curve set, its sizes in those of muscle 1."""
    curves = muscle.curves
    sizes = relative(muscle.sizes, first.sizes)
    unlike = [key for key in sizes if key not in curves.parameters and sizes[key] != 1]
    if unlike:
        raise ScenarioError(
            f"{name}: curves {curves.name} have no size of their own: {', '.join(unlike)} must be that of muscle1"
        )
    numbers = {key: {**muscle.numbers, **sizes}[key] for key in curves.parameters}
    if objection := curves.objection({key: numbers[key] for key in curves.tendon}):
        raise ScenarioError(f"{name}: {objection}")
    return numbers
