"""How fast runs were computed: what an earlier start has left does not count."""

from __future__ import annotations

import time
from collections.abc import Callable

from ..reports.number import counted


class Pace:
    """Passes progress on, and keeps when the first and the last word of it came."""

    def __init__(self, progress: Callable[[int, int], None]) -> None:
        self._progress = progress
        self._came: list[tuple[int, float]] = []

    def __call__(self, done: int, of: int) -> None:
        """`done` runs of `of` are there."""
        self._came = [*self._came[:1], (done, time.monotonic())]
        self._progress(done, of)

    def sentences(self) -> list[str]:
        """Runs, time and rate; nothing if all was there already."""
        if len(self._came) < 2:
            return []
        (before, start), (after, end) = self._came
        seconds = max(end - start, 1e-9)  # a clock of coarse ticks may stand still
        runs = after - before
        return [f"computed {counted(runs, 'run')} in {seconds:.2g} s, {runs / seconds:,.0f} a second"]
