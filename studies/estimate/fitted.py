"""The Kalman filter as it follows a recording: passed as a whole, with densities and form by likelihood."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from ...codegen.failure import Failure
from ...model.arrays import Array
from ...model.block import STEP, Block
from ...model.system import System
from ...observers.kalman.activations import ACTIVATIONS_MODEL
from ...observers.kalman.apart.activations import LAW_MODEL
from ...observers.kalman.apart.integrators import JOINT_MODEL, MUSCLE_MODEL
from ...observers.kalman.inputs import INPUTS_MODEL
from ..files.errors import RecordingError
from ..files.progress import Progress
from ..kalman.apart.record import RecordApart
from ..kalman.apart.run import ChoiceApart, passed_apart
from ..kalman.muscles import compiled_muscles
from ..kalman.orders import Choice, found_numbers, manifest
from ..kalman.passes import compiled
from ..kalman.record import Record, refuse_short
from ..kalman.run import ACTIVATIONS, INPUTS, How, Passed, passed
from ..kalman.tendons import about_estimates
from .case import Case, Result


def fitted_result(case: Case, block: Block, numbers: Mapping[str, float], progress: Progress) -> Result:
    """What the filter `block` makes of a recording; numbers: values of its parameters by name."""
    refuse_short(case.recording.source, len(case.tau))
    by_hand = {
        name: value
        for path, value in case.settings.changes.items()
        for owner, _, name in [path.partition(".")]
        if owner == block.name
    }
    how, of = _how(case), _of_pair if case.subject.pair else _of_mechanism
    outputs, gains, told = of(case, numbers, how, by_hand, progress)
    y = {name: outputs[name] for name in block.y}
    failure = _failure(case, block, numbers, y)
    guards = {name: outputs[name] for name in block.guards if name in outputs}
    if failure:
        from_then_on = case.tau[case.kept] >= failure.time
        for values in (*y.values(), *guards.values()):
            values[from_then_on] = np.nan
    late = (how.lag or 0) * case.period / case.scales.rate
    gains = {f"{block.name}.{name}": value for name, value in gains.items()}
    return Result(y, guards, gains, 1, [], failure, {**told, "lag": late})


def pair_record(case: Case, numbers: Mapping[str, float]) -> Record:
    """A recording of a pair as the filter's passes take it; numbers: values of the filter's parameters by name."""
    sizes, curves = case.sizes.pair, case.pair.curves
    return about_estimates(
        Record(case.tau, case.y, case.z, case.slopes, ~case.gaps, numbers, sizes, case.period, curves)
    )


def record_apart(case: Case, numbers: Mapping[str, float]) -> RecordApart:
    """The same of a mechanism."""
    return RecordApart(
        case.tau, case.y, case.z, case.slopes, ~case.gaps, numbers, case.sizes, case.period, case.subject.laws
    )


def compile_passes(system: System) -> None:
    """Compile what the filter needs, or load it from the cache."""
    compiled_muscles(system)
    for model in (INPUTS_MODEL, ACTIVATIONS_MODEL) if system.paper else (JOINT_MODEL, MUSCLE_MODEL, LAW_MODEL):
        compiled(model)


# outputs by name, numbers found, and what is told of the fit
Found = tuple[Mapping[str, Array], Mapping[str, float], dict[str, Any]]


def _of_pair(
    case: Case, numbers: Mapping[str, float], how: How, by_hand: Mapping[str, float], progress: Progress
) -> Found:
    found = passed(pair_record(case, numbers), how, by_hand, case.settings.keep_every, progress)
    return found.outputs, found_numbers(_chosen(found)), _told(found)


def _of_mechanism(
    case: Case, numbers: Mapping[str, float], how: How, by_hand: Mapping[str, float], progress: Progress
) -> Found:
    found = passed_apart(record_apart(case, numbers), how, by_hand, case.settings.keep_every, progress)
    gains = {
        f"{of}.{name}": value
        for of, choice in found.choices.items()
        for name, value in found_numbers(choice.counting).items()
    }
    chains = {of: {**_told(choice), "jumps": choice.inputs.jumps} for of, choice in found.choices.items()}
    return found.outputs, gains, {"chains": chains}


def _told(choice: Passed | ChoiceApart) -> dict[str, Any]:
    """Form and numbers of both passes in words of JSON."""
    choices = {INPUTS: choice.inputs, **({ACTIVATIONS: choice.activations} if choice.activations else {})}
    return {"form": choice.form, **{form: manifest(of_form) for form, of_form in choices.items()}}


def _how(case: Case) -> How:
    """RecordingError if the recording is shorter than its lag."""
    settings, time = case.settings, case.recording.time
    if settings.smooth:
        return How(settings.form, None)
    if settings.lag > (duration := float(time[-1] - time[0])):
        raise RecordingError(
            f"{case.recording.source}: a lag of {settings.lag:g} s is longer than the recording, {duration:.4g} s; "
            "smooth (--smooth) knows all samples"
        )
    # a lag of less than half a sample is none
    return How(settings.form, round(settings.lag * case.scales.rate / case.period))


def _chosen(found: Passed) -> Choice:
    return found.activations if found.form == ACTIVATIONS and found.activations else found.inputs


def _failure(case: Case, block: Block, numbers: Mapping[str, float], y: Mapping[str, Array]) -> Failure | None:
    """The first estimate that is no number within its limit."""
    limits = ca.Function("limits", [block.p.vector(), STEP], [block.limits.vector()])
    values = np.array(limits([numbers[name] for name in block.p], case.period), dtype=float)[:, 0]
    first: tuple[int, str, float] | None = None
    for name, limit in zip(block.limits, values, strict=True):
        if name in y and not (within := np.abs(y[name]) <= limit).all():
            at = int(np.argmin(within))
            first = min(first or (at, name, limit), (at, name, limit))
    return first and Failure(float(case.tau[case.kept][first[0]]), "y", first[1], first[2])
