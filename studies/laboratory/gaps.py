"""What an observer cannot be given: short gaps are bridged, long ones and what no muscle can do are refused."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...model.arrays import Array
from ..files.errors import RecordingError
from .muscles import Muscle
from .recording import Recording
from .subject import Bound, Subject

# seconds; a muscle does not do much in it
LONGEST_GAP = 0.1
# part of F_max that noise may push a force below 0; De Groote and Fregly's tendon gives no less than −0.2
_LOWEST_FORCE = -0.15
# F_max that no muscle reaches, not even while it is stretched (less than 2): the unit or the muscle is another
_HIGHEST_FORCE = 10.0
# periods; where samples are rare anyway a step may be longer than a gap
_LONGEST_STEP = 3.0


def bridged(recording: Recording) -> tuple[Array, NDArray[np.bool_]]:
    """What was measured (n × columns), gaps bridged in straight lines, and where.

    RecordingError names a gap that is too long.
    """
    inputs = np.stack(list(recording.measured.values()), axis=1)
    missing = np.isnan(inputs)
    for i, name in enumerate(recording.measured):
        known = ~missing[:, i]
        if known.all():
            continue
        if not known[0] or not known[-1]:
            row = recording.rows[0 if not known[0] else -1]
            raise RecordingError(f"{recording.source}: {name} has no value in row {row}, an end of the recording")
        _refuse_long_gaps(recording, name, known)
        inputs[~known, i] = np.interp(recording.time[~known], recording.time[known], inputs[known, i])
    return inputs, np.asarray(missing.any(axis=1))


def bounds(subject: Subject) -> dict[str, Bound]:
    """What each measured column may be: a position that can be, a force near those that a muscle can make."""
    return {**subject.positions, **{name: _of_force(muscle) for name, muscle in subject.forces.items()}}


def _of_force(muscle: Muscle) -> Bound:
    least, most = (part * muscle.F_max for part in (_LOWEST_FORCE, _HIGHEST_FORCE))
    below = "a tendon only pulls, so forces are positive"
    return Bound("N", least, most, below, f"F_max is {muscle.F_max:g} N; is it in another unit?")


def refuse_impossible(recording: Recording, subject: Subject) -> None:
    """RecordingError if a position is none that can be, or a force is far below 0 or above what muscles can do."""
    for name, bound in bounds(subject).items():
        for wrong in (recording[name] < bound.least, recording[name] > bound.most):
            if wrong.any():
                at = int(wrong.argmax())
                raise RecordingError(
                    f"{recording.source}: row {recording.rows[at]}: {bound.refusal(name, recording[name][at])}"
                )


def longest_step(period: float) -> float:
    """How far samples may be apart, in s, where they usually are a period apart."""
    return max(LONGEST_GAP, _LONGEST_STEP * period)


def refuse_long_steps(recording: Recording) -> None:
    """RecordingError if rows are missing for longer than a gap may be."""
    steps = np.diff(recording.time)
    longest = longest_step(float(np.median(steps)))
    if steps.max() > longest:
        before = int(steps.argmax())
        raise RecordingError(
            f"{recording.source}: there is no sample between rows {recording.rows[before]} and "
            f"{recording.rows[before + 1]}, {steps[before]:.3g} s; gaps of up to {longest:.3g} s are bridged"
        )


def _refuse_long_gaps(recording: Recording, name: str, known: NDArray[np.bool_]) -> None:
    places = np.flatnonzero(known)
    lengths = np.where(np.diff(places) > 1, np.diff(recording.time[places]), 0.0)
    if lengths.max() > LONGEST_GAP:
        before, after = places[lengths.argmax()], places[lengths.argmax() + 1]
        raise RecordingError(
            f"{recording.source}: {name} has no value in rows {recording.rows[before] + 1} to "
            f"{recording.rows[after] - 1}, {lengths.max():.3g} s; gaps of up to {LONGEST_GAP:g} s are bridged"
        )
