"""What is known after a sample, in SI and with names."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from ...model.arrays import Array
from ..estimate.quantities import OF_JOINTS, OF_MUSCLES
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
    """The names of a subject's joints and muscles, given to numbers."""

    def __init__(self, subject: Subject) -> None:
        self._joints, self._muscles = subject.joints, subject.labels
        self._missing = [math.nan] * max(len(subject.system.joints), len(subject.system.muscles))

    def of_joints(self, values: list[float]) -> OfJoints:
        """Joint → value; a pair's one position needs no name."""
        return dict(zip(self._joints, values, strict=False)) if self._joints else values[0]

    def of_muscles(self, values: list[float]) -> OfMuscles:
        """Muscle → value."""
        return dict(zip(self._muscles, values, strict=False))

    def estimate(self, time: float, age: float, of: Mapping[str, Array], sd: Mapping[str, Array] | None) -> Estimate:
        """Quantity → values (joints or muscles), and their deviations, with names."""
        joints, muscles = self.of_joints, self.of_muscles
        return Estimate(
            time,
            age,
            joints(of["position"].tolist()),
            joints(of["velocity"].tolist()),
            joints(of["disturbance"].tolist()),
            muscles(of["tendon_length"].tolist()),
            muscles(of["fibre_length"].tolist()),
            muscles(of["fibre_velocity"].tolist()),
            muscles(of["activation"].tolist()),
            None if sd is None else self._deviations(sd),
        )

    def nothing(self, time: float, age: float) -> Estimate:
        """No estimates."""
        of_joints = (self.of_joints(self._missing) for _ in OF_JOINTS)
        of_muscles = (self.of_muscles(self._missing) for _ in OF_MUSCLES)
        return Estimate(time, age, *of_joints, *of_muscles, None)  # type: ignore[arg-type]  # as many as there are

    def _deviations(self, sd: Mapping[str, Array]) -> dict[str, OfJoints | OfMuscles]:
        of_joints = {name: self.of_joints(sd[name].tolist()) for name in OF_JOINTS}
        return {**of_joints, **{name: self.of_muscles(sd[name].tolist()) for name in OF_MUSCLES}}
