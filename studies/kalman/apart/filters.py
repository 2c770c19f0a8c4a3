"""The filters of all joints and muscles of a recording, one after the other: muscles know how the joints move."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ....model.arrays import Array
from ....model.symbols import hat
from ....observers.behind.spread import entry
from ....observers.kalman.apart.integrators import JOINT_MODEL, MUSCLE_MODEL
from ...files.progress import Progress
from ..muscles import LAW, compiled_muscles
from ..orders import Choice
from ..record import segments, settled
from ..run import How
from .chain import Chain, Told
from .record import Forces, Motion, RecordApart

# velocities in accelerations, and smoothed forces in these: what changes after so many rounds is far below noise
_CAUSAL_ROUNDS, _SMOOTHED_ROUNDS = 2, 2

# of each joint and muscle by name
Numbers = Mapping[str, Mapping[str, float]]


class Filters:
    """Those of a recording. by_hand: numbers such as `elbow.s_D` that are to stay as they are.

    about: the motion whose velocities are in the accelerations.
    """

    def __init__(self, record: RecordApart, by_hand: Mapping[str, float], about: Motion) -> None:
        def chain(of: str) -> Chain:
            model = JOINT_MODEL if of in record.joints else MUSCLE_MODEL
            given, hand = ({**of_all, **_of(of, of_all)} for of_all in (record.numbers, by_hand))
            return Chain(model, record.sizes.near(of), record.T, given, hand)

        self.record, self._by_hand, self._about = record, by_hand, about
        self._chains = {of: chain(of) for of in (*record.joints, *record.muscles)}

    def __len__(self) -> int:
        return len(self._chains)

    def linear(self) -> Filters:
        """Those about what they tell with the numbers that the sizes of the recording let expect: so are tendons.

        Numbers by hand count later, so that what was found and is given back finds the same.
        """
        record, at = self.record, self._about
        numbers = {of: replace(chain, by_hand={}).expected() for of, chain in self._chains.items()}
        # velocities in the accelerations are those of the round before
        for _ in range(_CAUSAL_ROUNDS):
            at = self.motion(self._told(record.of_joints(at, record.forces), numbers, How()))
        tendons = lengths(self.muscles(numbers, at, How()))
        return Filters(record.about(tendons), self._by_hand, at)

    def chosen_joints(self, steps: Iterator[Progress], forces: Forces | None = None) -> dict[str, Choice]:
        """The likeliest numbers of each joint, by forces as they were measured unless others are given."""
        return self.chosen(self.record.of_joints(self._about, forces or self.record.forces), steps)

    def chosen_law(
        self, inputs: Mapping[str, Choice], rows: Mapping[str, Array], steps: Iterator[Progress]
    ) -> dict[str, Choice]:
        """The likeliest numbers of the second pass of muscles, by the rows that this has."""
        found = {}
        for of, whole in rows.items():
            found[of] = self._chains[of].chosen_law(fitted_to(whole), inputs[of])
            next(steps)(1.0)
        return found

    def joints(self, numbers: Numbers, how: How) -> dict[str, Told]:
        """What the chains of the joints tell."""
        record, forces = self.record, self.record.forces
        if how.lag is not None:
            return self._told(record.of_joints(self._about, forces), numbers, how)
        at = self.motion(self._told(record.of_joints(self._about, forces), numbers, How()))
        # smoothed forces have the noise of measured ones where it is slow, and none where it is fast
        smoothed = self.smoothed_forces(at)
        for _ in range(_SMOOTHED_ROUNDS):
            joints = self._told(record.of_joints(at, smoothed), numbers, how)
            at = self.motion(joints)
        return joints

    def motion(self, joints: Mapping[str, Told]) -> Motion:
        """That which the chains of the joints tell."""
        names = ("x1", "x2", entry("x2", "x2"))
        return Motion(self.record.laws, *(np.stack([t[name] for t in joints.values()], axis=1) for name in names))

    def muscles(self, numbers: Numbers, at: Motion, how: How) -> dict[str, Told]:
        """What the chains of the muscles tell, about joints that are as late already as `about` has them."""
        return self._told(self.record.of_muscles(at), numbers, _rest(how))

    def about(self, numbers: Numbers, how: How) -> Motion:
        """What muscles are to know of the joints: smoothed if `how` is, and half as late as estimates may be."""
        return self.motion(self.joints(numbers, how if how.lag is None else replace(how, lag=how.lag // 2)))

    def innovations(self, numbers: Numbers, how: How) -> Array:
        """Of each sensor, over their standard deviations (n × sensors); NaN where a sample does not count."""
        at = self.about(numbers, how)
        tables = {**self.record.of_joints(self._about, self.record.forces), **self.record.of_muscles(at)}
        ratios = [self._chains[of].innovations(rows, numbers[of]) for of, rows in tables.items()]
        return np.concatenate(ratios, axis=1)

    def law(self, inputs: Numbers, activations: Numbers, rows: Mapping[str, Array], how: How) -> dict[str, Told]:
        """What the second pass of some muscles tells."""
        return {
            of: self._chains[of].told(rows[of], _rest(how), inputs[of], numbers) for of, numbers in activations.items()
        }

    def lawful(self, numbers: Numbers, at: Motion, how: How) -> dict[str, Array]:
        """The rows of the second pass, linear about the first: smoothed if `how` is, causal if that is late only."""
        muscles = self.muscles(numbers, at, how if how.lag is None else How())
        law = self.law_about(muscles, at)
        law |= {f"{of}.x3_hat": told["x3"] for of, told in muscles.items()}
        return self.record.of_law(self.record.of_muscles(at), law)

    def law_about(self, muscles: Mapping[str, Told], at: Motion, shift: Array | float = 0.0) -> dict[str, Array]:
        """Hill's law, linear about what the chains of the muscles tell; shift: of tendon lengths (n × muscles)."""
        record, system = self.record, self.record.laws.system
        estimates = dict.fromkeys(system.estimates, np.zeros(len(record)))
        estimates |= dict(zip(map(hat, system.joint("q")), at.q.T, strict=True))
        estimates |= dict(zip(map(hat, system.muscle("L_S")), (lengths(muscles) + shift).T, strict=True))
        estimates |= {hat(system.name("u", of)): told["u1"] for of, told in muscles.items()}
        return compiled_muscles(system).outputs(LAW, record.numbers, estimates)

    def forces(self, lengths: Array) -> Array:
        """Of all tendons with these lengths (n × muscles)."""
        # F̂ = y + p(L̂_S − z)
        return self.record.forces.F + self.record.slopes * (lengths - self.record.z)

    def smoothed_forces(self, at: Motion) -> Forces:
        """Those of tendons that are smoothed alone: what joints do by these forces would come back to them."""
        record, rows = self.record, self.record.of_tendons()
        found = {of: self._chains[of].likeliest(fitted_to(table)).numbers for of, table in rows.items()}
        tendons = self._told(rows, found, How(lag=None))
        F = self.forces(lengths(tendons))
        speeds = np.array([self._chains[of].frequency(numbers) for of, numbers in found.items()])
        # that of the muscles, by their shares in the noise of a joint's acceleration
        noise = record.laws.acceleration_shares(at.q, F, record.sigma_F)
        total = noise.sum(axis=1, keepdims=True)
        shares = np.where(total > 0, noise, 1.0) / np.where(total > 0, total, noise.shape[1])
        return Forces(F, shares @ speeds)

    def chosen(self, tables: Mapping[str, Array], steps: Iterator[Progress]) -> dict[str, Choice]:
        """The likeliest numbers of joints or muscles by the rows that each has."""
        choices = {}
        for of, rows in tables.items():
            choices[of] = self._chains[of].chosen(fitted_to(rows))
            next(steps)(1.0)
        return choices

    def _told(self, tables: Mapping[str, Array], numbers: Numbers, how: How) -> dict[str, Told]:
        return {of: self._chains[of].told(rows, how, numbers[of]) for of, rows in tables.items()}


def _rest(how: How) -> How:
    """How late a muscle's estimate may be where the joints' are so by half of that."""
    return how if how.lag is None else replace(how, lag=how.lag - how.lag // 2)


def lengths(muscles: Mapping[str, Told]) -> Array:
    """Of all tendons (n × muscles)."""
    return np.stack([told["x3"] for told in muscles.values()], axis=1)


def numbers_of(choices: Mapping[str, Choice]) -> dict[str, Mapping[str, float]]:
    """The numbers chosen."""
    return {of: choice.fit.numbers for of, choice in choices.items()}


def fitted_to(rows: Array) -> list[Array]:
    """The rows of a table that numbers are found by."""
    return [settled(rows[part]) for part in segments(len(rows))]


def _of(of: str, numbers: Mapping[str, float]) -> dict[str, float]:
    """The numbers of a joint or muscle, without its name."""
    prefix = f"{of}."
    return {name.removeprefix(prefix): value for name, value in numbers.items() if name.startswith(prefix)}
