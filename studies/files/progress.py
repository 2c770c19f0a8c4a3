"""How a long computation says how far it is: the two kinds of callback, one that shows nothing, and parts of one."""

from __future__ import annotations

from collections.abc import Callable, Iterator

# the fraction done, from 0 to 1
Progress = Callable[[float], None]
# runs done and runs in all; what an earlier start has left counts as done at once
CountedProgress = Callable[[int, int], None]


def unseen(*_: float) -> None:
    """Either kind, where nobody watches."""


def shares(progress: Progress, parts: int) -> Iterator[Progress]:
    """A progress for each of some parts of equal length, one after the other."""

    def share(part: int) -> Progress:
        return lambda done: progress((part + done) / parts)

    return map(share, range(parts))
