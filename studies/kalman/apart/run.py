"""The filters of joints and muscles over a whole recording: numbers by likelihood, estimates causal or smoothed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ....model.arrays import Array
from ....model.symbols import hat
from ....observers.behind.spread import entry, sd
from ....observers.kalman.apart.estimates import MOVED
from ...files.progress import Progress, shares
from ..muscles import APART, compiled_muscles
from ..orders import Choice
from ..run import ACTIVATIONS, AUTO, INPUTS, How, form_of
from .chain import Told
from .filters import Filters, numbers_of
from .record import RecordApart

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
    filters = Filters(record, by_hand, record.measured).linear()
    inputs = inputs_apart(filters, how, fitting)
    numbers = numbers_of(inputs)
    joints = filters.joints(numbers, how)
    at = filters.about(numbers, how)
    muscles = filters.muscles(numbers, at, how)
    choices = {of: ChoiceApart(choice) for of, choice in inputs.items()}
    if how.form != INPUTS:
        rows = filters.lawful(numbers, at, how)
        found = filters.chosen_law(inputs, rows, shares(fitting_law, [1.0] * len(rows)))
        choices |= {of: ChoiceApart(inputs[of], law, _form(how, inputs[of], law)) for of, law in found.items()}
        lawful = {of: choice.counting.fit.numbers for of, choice in choices.items() if choice.form == ACTIVATIONS}
        for of, told in filters.law(numbers, lawful, rows, how).items():
            muscles[of] |= told
    fitting_law(1.0)
    for of, moved in zip(record.muscles, at.moved.T, strict=True):
        muscles[of][MOVED] = moved
    told = {
        f"{of}.{name}": values[::keep_every].copy()
        for of, chain in {**joints, **muscles}.items()
        for name, values in chain.items()
    }
    outputs = compiled_muscles(record.laws.system).outputs(APART, record.numbers, told)
    for of, choice in choices.items():
        if choice.form == ACTIVATIONS:
            outputs |= _estimated(record, of, told)
    passing(1.0)
    return PassedApart(choices, outputs)


def inputs_apart(filters: Filters, how: How, progress: Progress) -> dict[str, Choice]:
    """The likeliest numbers of the first pass, of each joint and then of each muscle about these.

    Smoothed if `how` is: causal velocities have noise that would count as an input's.
    """
    steps = shares(progress, [1.0] * len(filters))
    joints = filters.chosen_joints(steps)
    at = filters.about(numbers_of(joints), how)
    return {**joints, **filters.chosen(filters.record.of_muscles(at), steps)}


def _form(how: How, inputs: Choice, activations: Choice) -> str:
    """The likelier one unless one is asked for; but what jumps is smoothed by its input, as in `form_of`."""
    likelier = form_of(how, inputs, activations)
    return INPUTS if how.form == AUTO and not how.causal and inputs.jumps else likelier


def _estimated(record: RecordApart, of: str, told: Mapping[str, Array]) -> Told:
    """The activation that a muscle's second pass tells, its deviation, and where it is at a limit."""
    system = record.laws.system
    a, u = (system.name(signal, of) for signal in ("a", "u"))
    value, variance, moved = (told[f"{of}.{name}"] for name in ("a1", entry("a1", "a1"), MOVED))
    return {
        hat(a): np.clip(value, 0, 1),
        # what L̇_m is off by, the activation is off by ∂a/∂u times
        sd(a): np.sqrt(np.maximum(variance, 0) + moved / told[f"{of}.b_a"] ** 2),
        f"{hat(a)}_limit": ((value < 0) | (value > 1)).astype(float),
        # no activation is computed with it
        f"{hat(u)}_limit": np.zeros(len(value)),
    }
