"""The filters of all joints and muscles over a whole recording: numbers by likelihood, estimates causal or smoothed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ....model.arrays import Array
from ....model.symbols import hat
from ....observers.behind.spread import entry
from ....observers.kalman.apart.integrators import JOINT_MODEL, MUSCLE_MODEL
from ...files.progress import Progress, shares
from ..muscles import APART, TENDONS, compiled_muscles
from ..orders import Choice
from ..record import segments, settled
from ..run import How
from .chain import Chain, all_of
from .record import Forces, Motion, RecordApart

# velocities in accelerations, and smoothed forces in these: what changes after so many rounds is far below noise
_CAUSAL_ROUNDS, _SMOOTHED_ROUNDS = 2, 2
# shares of the time: numbers, estimates
_FIT, _PASS = 3.0, 1.0

Numbers = Mapping[str, Mapping[str, float]]
Told = dict[str, dict[str, Array]]


@dataclass(frozen=True, eq=False)
class PassedApart:
    """The choice for each joint and muscle, and each estimate, standard deviation and guard (kept samples) by name."""

    choices: Mapping[str, Choice]
    outputs: Mapping[str, Array]


class Apart:
    """A recording and its filters. by_hand: numbers such as `elbow.s_D` that are to stay as they are."""

    def __init__(self, record: RecordApart, by_hand: Mapping[str, float]) -> None:
        def chain(of: str) -> Chain:
            model = JOINT_MODEL if of in record.joints else MUSCLE_MODEL
            prefix = f"{of}."
            own = {name.removeprefix(prefix): value for name, value in by_hand.items()}
            given = {
                name: record.numbers.get(prefix + name, record.numbers.get(name, np.nan)) for name in model.parameters
            }
            hand = {name: value for name, value in own.items() if name in model.parameters}
            return Chain(model, record.sizes.near(of), record.T, given, hand)

        self.record = record
        self._chains = {of: chain(of) for of in (*record.joints, *record.muscles)}
        self._expected = {of: chain.expected() for of, chain in self._chains.items()}
        # velocities in the accelerations are those of the round before
        self._about = record.measured
        for _ in range(_CAUSAL_ROUNDS):
            self._about = self._motion(self._joints(self._expected, self._about, record.forces, How()))
        self.record = self._linear()

    def chosen(self, progress: Progress) -> dict[str, Choice]:
        """The likeliest numbers of each joint, then of each muscle about these."""
        steps = shares(progress, [1.0] * len(self._chains))
        joints = self._likeliest(self.record.of_joints(self._about, self.record.forces), steps)
        at = self._motion(self._joints(_numbers(joints), self._about, self.record.forces, How()))
        return {**joints, **self._likeliest(self.record.of_muscles(at), steps)}

    def told(self, choices: Mapping[str, Choice], how: How, keep_every: int) -> Told:
        """What each chain tells of every n-th sample."""
        numbers, forces = _numbers(choices), self.record.forces
        causal = self._joints(numbers, self._about, forces, How())
        at = self._motion(causal)
        if how.lag is not None:
            joints = causal if how.causal else self._joints(numbers, self._about, forces, how)
            return self._kept(joints, self._muscles(numbers, at, how), keep_every)
        # smoothed forces have the noise of measured ones where it is slow, and none where it is fast
        joints = self._joints(numbers, at, forces, how)
        for _ in range(_SMOOTHED_ROUNDS):
            at = self._motion(joints)
            forces = self._smoothed(at, self._muscles(numbers, at, how), numbers)
            joints = self._joints(numbers, at, forces, how)
        return self._kept(joints, self._muscles(numbers, self._motion(joints), how), keep_every)

    def _likeliest(self, tables: Mapping[str, Array], steps: Iterator[Progress]) -> dict[str, Choice]:
        choices = {}
        for of, rows in tables.items():
            choices[of] = self._chains[of].chosen([settled(rows[part]) for part in segments(len(rows))])
            next(steps)(1.0)
        return choices

    def _joints(self, numbers: Numbers, at: Motion, forces: Forces, how: How) -> Told:
        tables = self.record.of_joints(at, forces)
        return {of: all_of(self._chains[of].told(numbers[of], rows, how)) for of, rows in tables.items()}

    def _muscles(self, numbers: Numbers, at: Motion, how: How) -> Told:
        tables = self.record.of_muscles(at)
        return {of: all_of(self._chains[of].told(numbers[of], rows, how)) for of, rows in tables.items()}

    def _motion(self, joints: Told) -> Motion:
        q, dq, variance = (
            np.stack([told[name] for told in joints.values()], axis=1) for name in ("x1", "x2", entry("x1", "x1"))
        )
        return Motion(q, dq, variance)

    def _lengths(self, at: Motion, muscles: Told) -> Array:
        """Those of the tendons."""
        # L̂_S = (L_S − L_m) + L_m(q̂)
        return np.stack([told["rest"] for told in muscles.values()], axis=1) + self.record.laws.lengths(at.q)

    def _linear(self) -> RecordApart:
        """The record with tendons that are linear about causal estimates, not about measured forces."""
        record, system = self.record, self.record.laws.system
        lengths = self._lengths(self._about, self._muscles(self._expected, self._about, How()))
        given = dict(zip((hat(name) for name in system.muscle("L_S")), lengths.T, strict=True))
        given |= dict(zip(system.muscle("y"), record.forces.F.T, strict=True))
        lines = compiled_muscles(system).outputs(TENDONS, record.numbers, given)
        z, slopes = (np.stack([lines[name] for name in system.muscle(s)], axis=1) for s in ("z", "slope"))
        return replace(record, z=z, slopes=slopes)

    def _smoothed(self, at: Motion, muscles: Told, numbers: Numbers) -> Forces:
        """The forces of smoothed tendons."""
        record = self.record
        # F̂ = y + p(L̂_S − z)
        F = record.forces.F + record.slopes * (self._lengths(at, muscles) - record.z)
        speeds = np.array([self._chains[of].frequency(numbers[of]) for of in record.muscles])
        shares = record.laws.acceleration_shares(at.q, F, record.sigma_F)
        # that of the muscles, by their shares in the noise of a joint's acceleration
        total = shares.sum(axis=1, keepdims=True)
        shares = np.where(total > 0, shares / np.where(total > 0, total, 1.0), 1 / len(speeds))
        return Forces(F, shares @ speeds)

    def _kept(self, joints: Told, muscles: Told, keep_every: int) -> Told:
        return {
            of: {name: values[::keep_every].copy() for name, values in told.items()}
            for of, told in {**joints, **muscles}.items()
        }


def passed_apart(
    record: RecordApart, how: How, by_hand: Mapping[str, float], keep_every: int, progress: Progress
) -> PassedApart:
    """The estimates of a recording, of every n-th sample."""
    fitting, passing = shares(progress, [_FIT, _PASS])
    apart = Apart(record, by_hand)
    choices = apart.chosen(fitting)
    told = {
        f"{of}.{name}": values
        for of, chain in apart.told(choices, how, keep_every).items()
        for name, values in chain.items()
    }
    outputs = compiled_muscles(record.laws.system).outputs(APART, record.numbers, told)
    passing(1.0)
    return PassedApart(choices, outputs)


def _numbers(choices: Mapping[str, Choice]) -> dict[str, Mapping[str, float]]:
    return {of: choice.fit.numbers for of, choice in choices.items()}
