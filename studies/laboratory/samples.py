"""Samples in the order of a file: time rises strictly, repeated rows are left out, memory is bounded."""

from __future__ import annotations

import numpy as np

from ...model.arrays import Array
from ..files.errors import RecordingError
from .cells import Rows

# an hour at 1 kHz with all known columns is 75 million numbers; these are 2 GB
MOST_NUMBERS = 250_000_000


class Samples:
    """Collects rows as they are read; the first column is time."""

    def __init__(self) -> None:
        self._numbers = 0
        self._pieces: list[tuple[Rows, Array]] = []
        self._repeated: list[Rows] = [np.empty(0, dtype=np.int64)]
        self._last: tuple[Rows, Array] | None = None

    def __len__(self) -> int:
        return sum(len(rows) for rows, _ in self._pieces)

    def add(self, rows: Rows, values: Array) -> None:
        """More rows. RecordingError if time has a gap, runs backwards, or stands still while the data do not."""
        if not len(rows):
            return
        self._numbers += rows.size + values.size
        if self._numbers > MOST_NUMBERS:
            raise RecordingError(f"holds more than {MOST_NUMBERS:,} numbers; cut it into parts")
        last_row, last_values = self._last or (rows[:1] - 1, np.full_like(values[:1], -np.inf))
        numbers, lines = np.concatenate([last_values, values]), np.concatenate([last_row, rows])
        steps = np.diff(numbers[:, 0])
        if (bad := np.flatnonzero(~(steps > 0))).size:
            _refuse_unless_repeated(bad, steps, numbers, lines)
            kept = steps > 0
            self._repeated.append(rows[~kept])
            rows, values = rows[kept], values[kept]
        self._last = lines[-1:], numbers[-1:]
        self._pieces.append((rows, values))

    @property
    def rows(self) -> Rows:
        """The row in the file of each sample."""
        return np.concatenate([rows for rows, _ in self._pieces])

    @property
    def repeated(self) -> Rows:
        """The rows that were left out."""
        return np.concatenate(self._repeated)

    def column(self, i: int) -> Array:
        """All values of one column."""
        return np.concatenate([values[:, i] for _, values in self._pieces])


def _refuse_unless_repeated(places: Rows, steps: Array, numbers: Array, lines: Rows) -> None:
    """RecordingError for the first of the places where time does not rise, unless all repeat the row before."""
    before, after = numbers[places], numbers[places + 1]
    repeats = ((before == after) | (np.isnan(before) & np.isnan(after))).all(axis=1) & (steps[places] == 0)
    if repeats.all():
        return
    i = places[~repeats][0]
    time, row = numbers[i + 1, 0], lines[i + 1]
    if np.isnan(time):
        raise RecordingError(f"row {row} has no time")
    if steps[i] < 0:
        raise RecordingError(f"row {row}: time runs backwards, from {numbers[i, 0]:.12g} to {time:.12g}")
    raise RecordingError(
        f"row {row}: time {time:.12g} is that of row {lines[i]}, with other data; was time written with too few digits?"
    )
