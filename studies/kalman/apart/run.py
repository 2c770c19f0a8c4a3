"""The filters of all joints and muscles over a whole recording: numbers by likelihood, estimates causal or smoothed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....model.arrays import Array
from ....model.symbols import hat
from ....observers.behind.spread import entry, sd
from ....observers.kalman.apart.integrators import JOINT_MODEL, MUSCLE_MODEL
from ...files.progress import Progress, shares
from ..muscles import APART, LAW, TENDONS, compiled_muscles
from ..orders import Choice
from ..record import segments, settled
from ..run import ACTIVATIONS, INPUTS, How, form_of
from .chain import Chain, Told
from .record import Forces, Motion, RecordApart

# velocities in accelerations, and smoothed forces in these: what changes after so many rounds is far below noise
_CAUSAL_ROUNDS, _SMOOTHED_ROUNDS = 2, 2
# shares of the time: numbers of both passes, estimates
_FIT, _FIT_OF_LAW, _PASS = 2.0, 3.0, 1.0


@dataclass(frozen=True)
class ChoiceApart:
    """Of a joint or a muscle the numbers of both passes, as far as there are two, and which counts."""

    inputs: Choice
    activations: Choice | None = None
    form: str = INPUTS

    @property
    def counting(self) -> Choice:
        """That of the form which counts."""
        return self.activations if self.activations and self.form == ACTIVATIONS else self.inputs


@dataclass(frozen=True, eq=False)
class PassedApart:
    """The choice for each joint and muscle, and each estimate, standard deviation and guard (kept samples) by name."""

    choices: Mapping[str, ChoiceApart]
    outputs: Mapping[str, Array]


def passed_apart(
    record: RecordApart, how: How, by_hand: Mapping[str, float], keep_every: int, progress: Progress
) -> PassedApart:
    """The estimates of a recording, of every n-th sample.

    by_hand: numbers such as `elbow.s_D` that are to stay as they are.
    """
    fitting, fitting_law, passing = shares(progress, [_FIT, _FIT_OF_LAW, _PASS])
    apart = Apart(record, by_hand)
    inputs = apart.chosen(fitting)
    joints, at = apart.joints(inputs, how)
    muscles = apart.muscles(inputs, at, how)
    choices = {of: ChoiceApart(choice) for of, choice in inputs.items()}
    if how.form != INPUTS:
        rows = apart.lawful(inputs, at, how)
        for of, activations in apart.chosen_law(inputs, rows, fitting_law).items():
            form = form_of(how, inputs[of], activations)
            choices[of] = ChoiceApart(inputs[of], activations, form)
            if form == ACTIVATIONS:
                muscles[of] |= apart.of_law(of, choices[of], rows[of], how)
    fitting_law(1.0)
    told = {
        f"{of}.{name}": values[::keep_every].copy()
        for of, chain in {**joints, **muscles}.items()
        for name, values in chain.items()
    }
    outputs = compiled_muscles(record.laws.system).outputs(APART, record.numbers, told)
    for of in record.muscles:
        if choices[of].form == ACTIVATIONS:
            outputs |= _estimated(record, of, told)
    passing(1.0)
    return PassedApart(choices, outputs)


class Apart:
    """A recording and the filters of its joints and muscles."""

    def __init__(self, record: RecordApart, by_hand: Mapping[str, float]) -> None:
        def chain(of: str) -> Chain:
            model = JOINT_MODEL if of in record.joints else MUSCLE_MODEL
            given, hand = ({**of_all, **_of(of, of_all)} for of_all in (record.numbers, by_hand))
            return Chain(model, record.sizes.near(of), record.T, given, hand)

        self._chains = {of: chain(of) for of in (*record.joints, *record.muscles)}
        expected = {of: chain.expected() for of, chain in self._chains.items()}
        self.record = record
        # velocities in the accelerations are those of the round before
        self._about = record.measured
        for _ in range(_CAUSAL_ROUNDS):
            self._about = _motion(self._joints(expected, self._about, record.forces, How()))
        self.record = self._linear(self._muscles(expected, self._about, How()))

    def chosen(self, progress: Progress) -> dict[str, Choice]:
        """The likeliest numbers of each joint, then of each muscle about these."""
        steps = shares(progress, [1.0] * len(self._chains))
        joints = self._likeliest(self.record.of_joints(self._about, self.record.forces), steps)
        at = _motion(self._joints(_numbers(joints), self._about, self.record.forces, How()))
        return {**joints, **self._likeliest(self.record.of_muscles(at), steps)}

    def joints(self, choices: Mapping[str, Choice], how: How) -> tuple[dict[str, Told], Motion]:
        """What the chains of the joints tell, and the motion that muscles are to know of."""
        numbers, forces = _numbers(choices), self.record.forces
        causal = self._joints(numbers, self._about, forces, How())
        at = _motion(causal)
        if how.lag is not None:
            return causal if how.causal else self._joints(numbers, self._about, forces, how), at
        # smoothed forces have the noise of measured ones where it is slow, and none where it is fast
        joints = self._joints(numbers, at, forces, how)
        for _ in range(_SMOOTHED_ROUNDS):
            at = _motion(joints)
            joints = self._joints(numbers, at, self._smoothed(at, self._muscles(numbers, at, how), numbers), how)
        return joints, _motion(joints)

    def muscles(self, choices: Mapping[str, Choice], at: Motion, how: How) -> dict[str, Told]:
        """What the chains of the muscles tell."""
        return self._muscles(_numbers(choices), at, how)

    def lawful(self, choices: Mapping[str, Choice], at: Motion, how: How) -> dict[str, Array]:
        """The tables of the second pass, linear about the first: smoothed if `how` is, causal if that is late only."""
        record, system = self.record, self.record.laws.system
        muscles = self.muscles(choices, at, how if how.lag is None else How())
        estimates = dict.fromkeys(system.estimates, np.zeros(len(record)))
        estimates |= _named(system.joint("q"), at.q) | _named(system.muscle("L_S"), self._lengths(at, muscles))
        estimates |= {hat(system.name("u", of)): told["u1"] for of, told in muscles.items()}
        law = compiled_muscles(system).outputs(LAW, record.numbers, estimates)
        law |= {f"{of}.rest_hat": told["rest"] for of, told in muscles.items()}
        return record.of_law(record.of_muscles(at), law)

    def chosen_law(
        self, choices: Mapping[str, Choice], rows: Mapping[str, Array], progress: Progress
    ) -> dict[str, Choice]:
        """The likeliest numbers of each muscle's second pass."""
        steps, found = shares(progress, [1.0] * len(rows)), {}
        for of, whole in rows.items():
            found[of] = self._chains[of].chosen_law(_fitted_to(whole), choices[of])
            next(steps)(1.0)
        return found

    def of_law(self, of: str, choice: ChoiceApart, rows: Array, how: How) -> Told:
        """What a muscle's second pass tells."""
        return self._chains[of].told(rows, how, choice.inputs.fit.numbers, choice.counting.fit.numbers)

    def _likeliest(self, tables: Mapping[str, Array], steps: Iterator[Progress]) -> dict[str, Choice]:
        choices = {}
        for of, rows in tables.items():
            choices[of] = self._chains[of].chosen(_fitted_to(rows))
            next(steps)(1.0)
        return choices

    def _joints(
        self, numbers: Mapping[str, Mapping[str, float]], at: Motion, forces: Forces, how: How
    ) -> dict[str, Told]:
        return self._all(self.record.of_joints(at, forces), numbers, how)

    def _muscles(self, numbers: Mapping[str, Mapping[str, float]], at: Motion, how: How) -> dict[str, Told]:
        return self._all(self.record.of_muscles(at), numbers, how)

    def _all(
        self, tables: Mapping[str, Array], numbers: Mapping[str, Mapping[str, float]], how: How
    ) -> dict[str, Told]:
        return {of: self._chains[of].told(rows, how, numbers[of]) for of, rows in tables.items()}

    def _lengths(self, at: Motion, muscles: Mapping[str, Told]) -> Array:
        """Those of the tendons."""
        # L̂_S = (L_S − L_m) + L_m(q̂)
        return np.stack([told["rest"] for told in muscles.values()], axis=1) + self.record.laws.lengths(at.q)

    def _linear(self, muscles: Mapping[str, Told]) -> RecordApart:
        """The record with tendons that are linear about causal estimates, not about measured forces."""
        record, system = self.record, self.record.laws.system
        given = _named(system.muscle("L_S"), self._lengths(self._about, muscles))
        given |= dict(zip(system.muscle("y"), record.forces.F.T, strict=True))
        lines = compiled_muscles(system).outputs(TENDONS, record.numbers, given)
        z, slopes = (np.stack([lines[name] for name in system.muscle(s)], axis=1) for s in ("z", "slope"))
        return replace(record, z=z, slopes=slopes)

    def _smoothed(self, at: Motion, muscles: Mapping[str, Told], numbers: Mapping[str, Mapping[str, float]]) -> Forces:
        """The forces of smoothed tendons."""
        record = self.record
        # F̂ = y + p(L̂_S − z)
        F = record.forces.F + record.slopes * (self._lengths(at, muscles) - record.z)
        speeds = np.array([self._chains[of].frequency(numbers[of]) for of in record.muscles])
        # that of the muscles, by their shares in the noise of a joint's acceleration
        noise = record.laws.acceleration_shares(at.q, F, record.sigma_F)
        total = noise.sum(axis=1, keepdims=True)
        shares = np.where(total > 0, noise, 1.0) / np.where(total > 0, total, noise.shape[1])
        return Forces(F, shares @ speeds)


def _estimated(record: RecordApart, of: str, told: Mapping[str, Array]) -> Told:
    """The activation that a muscle's second pass tells, its deviation, and where it is at a limit."""
    system = record.laws.system
    a, a_hat, u_hat = system.name("a", of), hat(system.name("a", of)), hat(system.name("u", of))
    value, variance = told[f"{of}.a1"], told[f"{of}.{entry('a1', 'a1')}"]
    return {
        a_hat: np.clip(value, 0, 1),
        sd(a): np.sqrt(np.maximum(variance, 0)),
        f"{a_hat}_limit": ((value < 0) | (value > 1)).astype(float),
        # no activation is computed with it
        f"{u_hat}_limit": np.zeros(len(value)),
    }


def _motion(joints: Mapping[str, Told]) -> Motion:
    q, dq, variance = (
        np.stack([told[name] for told in joints.values()], axis=1) for name in ("x1", "x2", entry("x1", "x1"))
    )
    return Motion(q, dq, variance)


def _numbers(choices: Mapping[str, Choice]) -> dict[str, Mapping[str, float]]:
    return {of: choice.fit.numbers for of, choice in choices.items()}


def _of(of: str, numbers: Mapping[str, float]) -> dict[str, float]:
    """The numbers of a joint or muscle, without its name."""
    prefix = f"{of}."
    return {name.removeprefix(prefix): value for name, value in numbers.items() if name.startswith(prefix)}


def _fitted_to(rows: Array) -> list[Array]:
    return [settled(rows[part]) for part in segments(len(rows))]


def _named(names: Sequence[str], columns: Array) -> dict[str, Array]:
    """Estimates by name."""
    return dict(zip(map(hat, names), columns.T, strict=True))
