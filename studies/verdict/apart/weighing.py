"""How likely a recording of a mechanism is with another muscle, other forces, angles or masses, in SI."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from ....model.symbols import hat
from ...estimate.run import recorded_apart
from ...files.progress import shares, unseen
from ...kalman.apart.filters import Filters, fitted_to, lengths, numbers_of
from ...kalman.apart.record import RecordApart
from ...kalman.apart.run import inputs_apart
from ...kalman.muscles import TENDONS, compiled_muscles
from ...kalman.orders import Choice
from ...kalman.run import How
from ...laboratory.laws import Laws
from ...laboratory.muscles import Muscle
from ...laboratory.recording import Recording
from ...laboratory.scales import curve_numbers
from ...laboratory.subject import Subject
from ..hanging import NO_NOISE

# muscles are weighed about what the joints surely did: noise of velocities would be taken for that of fibres
_SMOOTHED = How(lag=None)
# largest noise of an acceleration in the acceleration itself, where forces tell of masses
_LOUD = 0.5
# Newton's steps to the length at which another tendon has a force
_STEPS = 8


class Weighing:
    """A recording with a mechanism as it is. orders: `elbow.order_D`, `BRA.order_u` and so on, as far as known."""

    def __init__(self, read: Recording, subject: Subject, orders: Mapping[str, float]) -> None:
        self.case, record = recorded_apart(read, subject)
        self._subject, self._filters = subject, Filters(record, orders, record.measured).linear()
        self.inputs = inputs_apart(self._filters, _SMOOTHED, unseen)
        numbers = numbers_of(self.inputs)
        self._at = self._filters.about(numbers, _SMOOTHED)
        rows = self._filters.lawful(numbers, self._at, How())
        self.activations = self._filters.chosen_law(self.inputs, rows, shares(unseen, [1.0] * len(rows)))
        self._orders = {**orders, **_orders(self.inputs), **_orders(self.activations)}
        muscles = self._filters.muscles(numbers, self._at, How())
        self._lengths = lengths(muscles)
        self._forces = self._filters.forces(self._lengths)

    @property
    def record(self) -> RecordApart:
        """The recording as the filters take it."""
        return self._filters.record

    @property
    def noisy(self) -> bool:
        """Whether there is noise of positions to speak of."""
        return min(joint.sigma for joint in self.case.sizes.joints.values()) > NO_NOISE

    @property
    def forceful(self) -> bool:
        """Whether noise of the forces leaves enough of what they do to the joints to tell masses."""
        record, at = self.record, self._at
        moved = record.laws.accelerations(at.q, at.dq, self._forces).std(axis=0)
        noise = np.sqrt(record.laws.acceleration_variances(at.q, self._forces, record.sigma_F).mean(axis=0))
        return bool((noise <= _LOUD * moved).all())

    def other_muscle(self, of: str, muscle: Muscle) -> float:
        """How much likelier it is with another muscle of this name, whose chain alone that concerns."""
        reference, first = next(iter(self._subject.muscles.items()))
        # the search begins with the densities of the muscle as it is
        own = {**self.activations[of].fit.numbers, **curve_numbers(of, muscle, reference, first)}
        record = self._with_tendons({**self.record.numbers, **{f"{of}.{name}": value for name, value in own.items()}})
        filters = Filters(record, self._orders, self._at)
        rows = filters.lawful(numbers_of(self.inputs), self._at, How())[of]
        law = filters.chosen_law(self.inputs, {of: rows}, shares(unseen, [1.0]))
        return _likelihood(record, law, [of]) - _likelihood(self.record, self.activations, [of])

    def other_recording(self, read: Recording, scale: float = 1.0) -> float:
        """How much likelier other measurements are, by the first pass of all joints and muscles.

        scale: by which one of them is larger.
        """
        _, record = recorded_apart(read, self._subject)
        filters = Filters(record, self._orders, record.measured).linear()
        found = inputs_apart(filters, _SMOOTHED, unseen)
        gain = _likelihood(filters.record, found, found) - _likelihood(self.record, self.inputs, self.inputs)
        # p(q) = scale p(scale q)
        return gain + len(read) * float(np.log(scale))

    def other_masses(self, laws: Laws) -> float:
        """How much likelier it is with links that obey other laws, by smoothed forces: noise favours heavy links."""
        forces = self._filters.smoothed_forces(self._at)

        def likelihood(record: RecordApart) -> float:
            filters = Filters(record, self._orders, self._at)
            joints = filters.chosen_joints(shares(unseen, [1.0] * len(filters)), forces)
            return _likelihood(record, joints, joints)

        return likelihood(replace(self.record, laws=laws)) - likelihood(self.record)

    def biased(self, newtons: Mapping[str, float]) -> dict[str, float]:
        """Muscle → how much its activation changes in the median if its force is wrong by so much."""
        record, system = self.record, self.record.laws.system
        forces = np.array([newtons[of] for of in record.muscles]) / self.case.scales.force
        muscles = self._filters.muscles(numbers_of(self.inputs), self._at, How())
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            before, after = (
                self._filters.law_about(muscles, self._at, shift) for shift in (0.0, forces / record.slopes)
            )
            return {of: float(np.median(np.abs(after[f"{of}.a_hat"] - before[f"{of}.a_hat"]))) for of in system.muscles}

    def _with_tendons(self, numbers: Mapping[str, float]) -> RecordApart:
        """The record with other numbers, and tendons that have the same forces."""
        system, tendons = self.record.laws.system, self._lengths
        forces = dict(zip(system.muscle("y"), self._forces.T, strict=True))
        for _ in range(_STEPS):
            # Φ_S(L_S) = F̂
            given = {**dict(zip(map(hat, system.muscle("L_S")), tendons.T, strict=True)), **forces}
            lines = compiled_muscles(system).outputs(TENDONS, numbers, given)
            tendons = np.stack([lines[name] for name in system.muscle("z")], axis=1)
        return replace(self.record, numbers=numbers).about(tendons)


def _likelihood(record: RecordApart, choices: Mapping[str, Choice], of: Iterable[str]) -> float:
    """log L of what joints and muscles have measured, that of muscles per newton of their unit of force."""
    total = 0.0
    for name in of:
        total += choices[name].fit.log_likelihood
        if name in record.muscles:
            m = record.muscles.index(name)
            # p(F) = p(z)/Φ′_S(z)
            (rows,) = fitted_to(record.of_muscles(record.measured)[name])
            total -= float(np.log(record.slopes[rows[:, -1] > 0, m]).sum())
    return total


def _orders(choices: Mapping[str, Choice]) -> dict[str, float]:
    """The orders chosen, by the names that a filter has for them."""
    return {
        f"{of}.{name}": value
        for of, choice in choices.items()
        for name, value in choice.fit.numbers.items()
        if name.startswith("order")
    }
