"""How far the slider of a number goes: what is worth trying, from its bounds and where it stands."""

from __future__ import annotations

import math

from ...model.block import Parameter
from ...model.symbols import SIGNALS, hat

# from a part of a number above 0 to so many times as much: of observers and noise, and of what they observe
FAR, NEAR = 10.0, 2.0
# away from the only bound, in ways to that bound
_FURTHER = 3.0
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
    if math.isinf(low) and math.isinf(high):
        return ((min(0.0, 2 * value), max(0.0, 2 * value)) if value else None), False
    if about.above == 0 and math.isinf(high):
        return (value / times, value * times), True
    if about.below == 0 and math.isinf(low):
        return (value * times, value / times), True
    down = value - low if math.isfinite(low) else _FURTHER * (high - value)
    up = high - value if math.isfinite(high) else _FURTHER * (value - low)
    # it stops before a bound that it must not reach
    down, up = (
        _NEARLY * way if strict else way for way, strict in ((down, about.above >= low), (up, about.below <= high))
    )
    return ((value - down, value + up) if down + up else None), False
