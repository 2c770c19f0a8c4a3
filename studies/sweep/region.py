"""Which points of a sweep something happens at, in words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .axes import Axes


def where(axes: Axes, chosen: NDArray[np.bool_]) -> str:
    """How many of the points `chosen`, and the range of their values: `at 3 of 9 points, all with a ≤ 0.1`."""
    if not axes.paths:
        return "here"
    if chosen.all():
        return "at every point"
    ranges = _ranges(axes, np.flatnonzero(chosen))
    return f"at {chosen.sum():,} of {chosen.size:,} points" + (f", all with {ranges}" if ranges else "")


def _ranges(axes: Axes, points: NDArray[np.int64]) -> str:
    """The least and the largest value of each axis, unless they are its ends."""
    words = []
    for path, values, taken in zip(axes.paths, axes.values, axes.at(points).T, strict=True):
        low, high = taken.min(), taken.max()
        starts, ends = low == values.min(), high == values.max()
        if low == high and not (starts and ends):
            words.append(f"{path} = {low:.4g}")
        elif starts and not ends:
            words.append(f"{path} ≤ {high:.4g}")
        elif ends and not starts:
            words.append(f"{path} ≥ {low:.4g}")
        elif not starts:
            words.append(f"{low:.4g} ≤ {path} ≤ {high:.4g}")
    return ", ".join(words)
