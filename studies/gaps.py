"""What an observer cannot be given: gaps are bridged if they are short, forces that no tendon has are refused."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..codegen.library import Array
from .columns import INPUTS
from .lines import RecordingError
from .muscle_file import MusclePair
from .recording import Recording

# seconds; a muscle does not do much in it
LONGEST_GAP = 0.1
# part of F_max that noise may push a force below 0; De Groote and Fregly's tendon gives no less than −0.2
_LOWEST_FORCE = -0.15


def bridged(recording: Recording) -> tuple[Array, NDArray[np.bool_]]:
    """The inputs (n × 3), gaps bridged in straight lines, and where. RecordingError names a gap that is too long."""
    inputs = np.stack([getattr(recording, name) for name in INPUTS], axis=1)
    missing = np.isnan(inputs)
    for i, name in enumerate(INPUTS):
        known = ~missing[:, i]
        if known.all():
            continue
        if not known[0] or not known[-1]:
            row = recording.rows[0 if not known[0] else -1]
            raise RecordingError(f"{recording.source}: {name} has no value in row {row}, an end of the recording")
        _refuse_long_gaps(recording, name, known)
        inputs[~known, i] = np.interp(recording.time[~known], recording.time[known], inputs[known, i])
    return inputs, missing.any(axis=1)


def refuse_impossible_forces(recording: Recording, pair: MusclePair) -> None:
    """RecordingError if a force is so far below 0 that it is no noise."""
    for name, muscle in (("force_1", pair.muscle1), ("force_2", pair.muscle2)):
        low = np.flatnonzero(getattr(recording, name) < _LOWEST_FORCE * muscle.F_max)
        if low.size:
            force, row = float(getattr(recording, name)[low[0]]), recording.rows[low[0]]
            raise RecordingError(
                f"{recording.source}: row {row}: {name} = {force:g} N; a tendon only pulls, so forces are positive"
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
