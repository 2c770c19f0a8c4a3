"""Signals over time on paper: a line where it can be followed, a band where noise would make it a solid area."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from ...model.arrays import Array
from . import style

# more than a printed line can show
_MOST_POINTS = 6000
# a line that travels up and down more panel heights than this would become a solid area
_CALM = 15.0
# across a panel; a band has one upper and one lower end for each
_STRETCHES = 150


def traces(axes: Axes, time: Array, signals: Mapping[str, Array], looks: Mapping[str, style.Style]) -> bool:
    """Draw signals of (time) within the limits that the axes have; whether any of them is a band.

    Bands are translucent and have the outline of their line, so that none hides another. One signal alone hides
    nothing and stays a line.
    """
    noisy = [name for name, signal in signals.items() if len(signals) > 1 and _travel(axes, time, signal) > _CALM]
    for name, signal in signals.items():
        if name in noisy:
            axes.fill_between(*_band(axes, time, signal), label=name, **style.band(looks[name]))
        else:
            line(axes, time, signal, looks[name], name)
    return bool(noisy)


def with_margin(values: Array, share: float) -> tuple[float, float]:
    """Limits that show all of the values, with a share of their range on either side."""
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    margin = share * (high - low) or 0.5
    return low - margin, high + margin


def line(axes: Axes, time: Array, signal: ArrayLike, look: style.Style, label: str) -> None:
    """A signal of (time) as one line."""
    values = np.asarray(signal)
    keep = _extremes(values)
    axes.plot(time[keep], values[keep], label=label, **look)


def _travel(axes: Axes, time: Array, signal: Array) -> float:
    """How far the line moves up and down in the axes, in their heights."""
    (begin, end), (low, high) = axes.get_xlim(), axes.get_ylim()
    shown = np.clip(signal[(time >= begin) & (time <= end)], low, high)
    return float(np.nansum(np.abs(np.diff(shown))) / (high - low))


def _band(axes: Axes, time: Array, signal: Array) -> tuple[Array, Array, Array]:
    """Time, lower and upper end of the band within the axes, straight between the ends of stretches.

    It holds every value that the axes show, and where the signal rises or falls it does so too, without widening.
    """
    (begin, end), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    inside = (time >= begin) & (time <= end)
    # what leaves the axes may be anything, even infinite
    time, signal = time[inside], np.clip(signal[inside], 2 * bottom - top, 2 * top - bottom)
    ends = np.unique(np.linspace(0, len(time) - 1, _STRETCHES + 1).astype(int))
    least, largest = _of_stretches(signal, ends)
    middle = (least + largest) / 2
    low, high = _of_stretches(signal - np.interp(time, time[ends], middle), ends)
    # the outline closes outside the axes
    return _widened(time[ends], end - begin), _widened(middle + low), _widened(middle + high)


def _widened(values: Array, by: float = 0.0) -> Array:
    """The values with one more on either side, `by` further out."""
    return np.concatenate([values[:1] - by, values, values[-1:] + by])


def _of_stretches(signal: Array, ends: NDArray[np.intp]) -> tuple[Array, Array]:
    """At each end the least and the largest of the stretches on both sides; what is no number does not count."""
    least, largest = (_widened(pick.reduceat(signal, ends[:-1])) for pick in (np.fmin, np.fmax))
    return np.fmin(least[:-1], least[1:]), np.fmax(largest[:-1], largest[1:])


def _extremes(values: Array) -> NDArray[np.intp]:
    """Which points to draw: all, or of a very long line the least and the largest of each stretch."""
    if len(values) <= _MOST_POINTS:
        return np.arange(len(values))
    stretches = np.array_split(np.arange(len(values)), _MOST_POINTS // 2)
    return np.unique([part[pick(values[part])] for part in stretches for pick in (np.argmin, np.argmax)])
