"""What is known after a sample, in SI and with names."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from ...model.arrays import Array
from ..laboratory.quantities import OF_JOINTS, OF_MUSCLES, quantities_of
from ..laboratory.subject import Subject

# of a pair's mass one number; of a mechanism joint → number
OfJoints = float | dict[str, float]
# muscle → number: 1 and 2 of a pair
OfMuscles = dict[int | str, float]


class Estimate(NamedTuple):
    """An observer's estimates at a sample; NaN where there are none.

    time: s, of the sample; age: s since the observer began, at the first sample or after a gap too long to bridge.
    position m or rad, velocity, disturbance N or N m: a number of a pair, joint → number of a mechanism. The others
    are muscle → number: tendon_length, fibre_length m, fibre_velocity m/s, positive when it lengthens, activation.
    sd: quantity → the same of the standard deviations that noise and unknown inputs leave, if the observer tells them.
    """

    time: float
    age: float
    position: OfJoints
    velocity: OfJoints
    disturbance: OfJoints
    tendon_length: OfMuscles
    fibre_length: OfMuscles
    fibre_velocity: OfMuscles
    activation: OfMuscles
    sd: dict[str, OfJoints | OfMuscles] | None


class Naming:
    """The names of a subject's joints and muscles, given to numbers in the order of `Quantities`."""

    def __init__(self, subject: Subject) -> None:
        self._joints, self._muscles = subject.joints, subject.labels
        self._places = quantities_of(subject).places
        self._missing = [math.nan] * max(place.stop for place in self._places.values())
        self._of_joints = [self._places[name] for name in OF_JOINTS]
        self._of_muscles = [self._places[name] for name in OF_MUSCLES]

    def estimate(self, time: float, age: float, numbers: list[float], sd: Mapping[str, Array] | None) -> Estimate:
        """The numbers in SI, and the deviations (joints or muscles), with names."""
        joints, muscles = self._joints, self._muscles
        if joints:
            parts: list[Any] = [dict(zip(joints, numbers[place], strict=True)) for place in self._of_joints]
        else:
            # a pair's one position needs no name
            parts = [numbers[place.start] for place in self._of_joints]
        parts += [dict(zip(muscles, numbers[place], strict=True)) for place in self._of_muscles]
        return Estimate._make([time, age, *parts, None if sd is None else self._deviations(sd)])

    def nothing(self, time: float, age: float) -> Estimate:
        """No estimates."""
        return self.estimate(time, age, self._missing, None)

    def _deviations(self, sd: Mapping[str, Array]) -> dict[str, OfJoints | OfMuscles]:
        found: dict[str, Any] = {name: sd[name].tolist() for name in (*OF_JOINTS, *OF_MUSCLES)}
        for name, values in found.items():
            labels = self._muscles if name in OF_MUSCLES else self._joints
            found[name] = dict(zip(labels, values, strict=True)) if labels else values[0]
        return found
