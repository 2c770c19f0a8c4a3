"""How a long computation says how far it is: the two kinds of callback, one that shows nothing, and parts of one."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence

# the fraction done, from 0 to 1
Progress = Callable[[float], None]
# runs done and runs in all; what an earlier start has left counts as done at once
CountedProgress = Callable[[int, int], None]


def unseen(*_: float) -> None:
    """Either kind, where nobody watches."""


def shares(progress: Progress, lengths: Sequence[float]) -> Iterator[Progress]:
    """A progress for each of some parts of these lengths, one after the other."""

    def share(start: float, length: float) -> Progress:
        return lambda done: progress((start + length * done) / ends[-1])

    ends = [0.0, *itertools.accumulate(lengths)]
    return map(share, ends, lengths)
