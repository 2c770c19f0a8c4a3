"""How far the slider of a number goes: what is worth trying, from its bounds and where it stands."""

from __future__ import annotations

import math

from ...model.block import Parameter
from ...model.symbols import SIGNALS, hat

# from a part of a number above 0 to so many times as much: of observers and noise, and of what they observe
FAR, NEAR = 10.0, 2.0
# from a bound that may be, to so many times the number
_TO = 4.0
# around a start, in usual sizes of the signal that starts
_SIZES = 10.0
# of the way to a bound that must not be reached
_NEARLY = 0.9

Reach = tuple[tuple[float, float] | None, bool]


def reach(path: str, about: Parameter, value: float, times: float) -> Reach:
    """From where to where a slider goes, and whether in equal ratios; None for a 0 that nothing gives a size."""
    low, high = max(about.above, about.least), min(about.below, about.most)
    owner, _, name = path.rpartition(".")
    if owner == "initial" and (signal := name.removesuffix(hat(""))) in SIGNALS:
        size = SIGNALS[signal].size * _SIZES
        return (value - size, value + size), False
    if value == 0 and math.isinf(high - low):
        return None, False
    if math.isinf(low) and math.isinf(high):
        return (min(0.0, 2 * value), max(0.0, 2 * value)), False
    if about.above == 0 and math.isinf(high):
        return (value / times, value * times), True
    if about.below == 0 and math.isinf(low):
        return (value * times, value / times), True
    # it stops before a bound that it must not reach
    low = value - (value - low) * (_NEARLY if about.above >= low else 1) if math.isfinite(low) else 2 * value - high
    high = value + (high - value) * (_NEARLY if about.below <= high else 1) if math.isfinite(high) else _TO * value
    return (low, high), False
