"""Samples in the order of a file: time rises strictly, repeated rows are left out, pieces have equal lengths."""

from __future__ import annotations

import numpy as np

from ...model.arrays import Array
from ..files.errors import RecordingError
from .cells import Rows

_MOST_ROWS = 200_000_000


class Samples:
    """Takes rows as they are read and gives them back in pieces of `size`; the first column is time."""

    def __init__(self, size: int) -> None:
        if size < 1:
            raise ValueError(f"a chunk must have at least 1 row, not {size}")
        self.left_out = 0
        self._size = size
        self._seen = 0
        self._pieces: list[tuple[Rows, Array]] = []
        self._repeated: list[Rows] = []
        self._last: tuple[Rows, Array] | None = None

    def __len__(self) -> int:
        return sum(len(rows) for rows, _ in self._pieces)

    @property
    def more_than_full(self) -> bool:
        """Whether a piece can be taken and something follows it."""
        return len(self) > self._size

    def add(self, rows: Rows, values: Array) -> None:
        """More rows. RecordingError if time has a gap, runs backwards, or stands still while the data do not."""
        if not len(rows):
            return
        self._seen += len(rows)
        if self._seen > _MOST_ROWS:
            raise RecordingError(f"has more than {_MOST_ROWS:,} rows")
        before = self._last or (rows[:1] - 1, np.full_like(values[:1], -np.inf))
        every, numbers = np.concatenate([before[1], values]), np.concatenate([before[0], rows])
        steps = np.diff(every[:, 0])
        if (bad := np.flatnonzero(~(steps > 0))).size:
            self._refuse(bad, steps, every, numbers)
            kept = steps > 0
            self._repeated.append(rows[~kept])
            self.left_out += int((~kept).sum())
            rows, values = rows[kept], values[kept]
        self._last = numbers[-1:], every[-1:]
        self._pieces.append((rows, values))

    def take(self) -> tuple[Rows, Array, Rows]:
        """The next piece: rows, values, and the rows that were left out since the last one."""
        # one piece is cut without a copy, however small the cuts
        rows, values = (
            self._pieces[0] if len(self._pieces) == 1 else map(np.concatenate, zip(*self._pieces, strict=True))
        )
        self._pieces = [(rows[self._size :], values[self._size :])]
        repeated = np.concatenate([np.empty(0, dtype=np.int64), *self._repeated])
        self._repeated = []
        return rows[: self._size], values[: self._size], repeated

    def _refuse(self, places: Rows, steps: Array, every: Array, numbers: Rows) -> None:
        """RecordingError for the first of the places where time does not rise, unless all repeat a row."""
        before, after = every[places], every[places + 1]
        repeats = ((before == after) | (np.isnan(before) & np.isnan(after))).all(axis=1) & (steps[places] == 0)
        if repeats.all():
            return
        i = places[~repeats][0]
        time, row = every[i + 1, 0], numbers[i + 1]
        if np.isnan(time):
            raise RecordingError(f"row {row} has no time")
        if steps[i] < 0:
            raise RecordingError(f"row {row}: time runs backwards, from {every[i, 0]:.12g} to {time:.12g}")
        raise RecordingError(
            f"row {row}: time {time:.12g} is that of row {numbers[i]}, with other data; "
            "was time written with too few digits?"
        )
