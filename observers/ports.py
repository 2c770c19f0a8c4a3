"""What all observers of the pair have in common: their ports."""

from __future__ import annotations

from ..model.system import PAIR, System
from .slopes import slopes_of

ESTIMATES = PAIR.estimates


def sensed(system: System = PAIR) -> tuple[str, ...]:
    """What is measured, and the tendon lengths that this tells."""
    return (*system.measured, *system.tendons)


def inputs(system: System = PAIR) -> tuple[str, ...]:
    """An observer is a Block with (some of) these inputs, and with all of the system's estimates as outputs."""
    return ("t", *sensed(system), *slopes_of(system))


# of the pair
SENSED = sensed()
