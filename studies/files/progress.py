"""How a long computation says how far it is: the two kinds of callback, and the one that shows nothing."""

from __future__ import annotations

from collections.abc import Callable

# the fraction done, from 0 to 1
Progress = Callable[[float], None]
# runs done and runs in all; what an earlier start has left counts as done at once
CountedProgress = Callable[[int, int], None]


def unseen(*_: float) -> None:
    """Either kind, where nobody watches."""
