"""The Kalman filter as it follows a recording: passed as a whole, with densities and form by likelihood."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from ...codegen.failure import Failure
from ...model.arrays import Array
from ...model.block import STEP, Block
from ..files.errors import RecordingError
from ..files.progress import Progress
from ..kalman.orders import Choice, found_numbers, manifest
from ..kalman.record import Record, refuse_short
from ..kalman.run import ACTIVATIONS, How, Passed, passed
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
    how = _how(case)
    found = passed(record_of(case, numbers), how, by_hand, case.settings.keep_every, progress)
    y = {name: found.outputs[name] for name in block.y}
    failure = _failure(case, block, numbers, y)
    guards = {name: found.outputs[name] for name in block.guards if name in found.outputs}
    if failure:
        from_then_on = case.tau[case.kept] >= failure.time
        for values in (*y.values(), *guards.values()):
            values[from_then_on] = np.nan
    gains = {f"{block.name}.{name}": value for name, value in found_numbers(_chosen(found)).items()}
    late = (how.lag or 0) * case.period / case.scales.rate
    return Result(y, guards, gains, 1, [], failure, {**_told(found), "lag": late})


def record_of(case: Case, numbers: Mapping[str, float]) -> Record:
    """A recording as the filter's passes take it; numbers: values of the filter's parameters by name."""
    sizes, curves = case.sizes.pair, case.pair.curves
    return about_estimates(
        Record(case.tau, case.y, case.z, case.slopes, ~case.gaps, numbers, sizes, case.period, curves)
    )


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


def _told(found: Passed) -> dict[str, Any]:
    choices = {"u": found.inputs, **({"a": found.activations} if found.activations else {})}
    return {"form": found.form, **{form: manifest(choice) for form, choice in choices.items()}}


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
