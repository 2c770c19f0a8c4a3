"""What the figures of a sweep share: a panel per quantity, scales that fit the values, the marks' looks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullFormatter

from ....model.arrays import Array
from ....model.symbols import signal_of
from ...sweep.optimum import axes_of, logarithmic, varied
from .. import style

OPTIMUM: style.Style = {"linestyle": "none", "marker": "o", "markersize": 5}
# the smallest of what was swept, which may be no optimum: at an edge, or where a gain condition does not hold
SMALLEST: style.Style = {**OPTIMUM, "markerfacecolor": "white", "markeredgewidth": 1.2}
OWN: style.Style = {"color": "0.35", "linestyle": (0, (1, 2)), "linewidth": 1.0}

_COLUMNS = 2
_ROW, _LONE_ROW, _AROUND = 1.7, 2.5, 0.8  # inches
# numbers that a whole axis has room for, horizontal or vertical
_ROOM_ACROSS, _ROOM_UP = 6, 5
# numbers of each power of ten, from many to few, about evenly in the logarithm
_BETWEEN = ((1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8), (1, 1.5, 2, 3, 5, 7), (1, 2, 5), (1, 3), (1,))
# with fewer an axis has no scale; then the numbers lie evenly
_FEWEST = 2
_STEPS = [1, 2, 5, 10]
# written without a power of ten
_SHORT = (1e-4, 1e4)


def flattened(dataset: xr.Dataset) -> xr.Dataset:
    """The Dataset of a grid with only those of its dimensions that vary, their values in order."""
    paths = varied(dataset)
    return dataset.isel({path: 0 for path in axes_of(dataset).paths if path not in paths}).sortby(paths)


def panels(quantities: Sequence[str]) -> tuple[Figure, dict[str, Axes]]:
    """A figure in two columns, a panel per quantity with its symbol above."""
    columns = min(_COLUMNS, len(quantities))
    rows = -(-len(quantities) // columns)
    height = _AROUND + (_ROW * rows if columns > 1 else _LONE_ROW)
    figure = Figure(figsize=(style.PAGE, height), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).flat
    for spare in list(grid)[len(quantities) :]:
        spare.remove()
    by_quantity = dict(zip(quantities, figure.axes, strict=True))
    for quantity, axes in by_quantity.items():
        axes.set_title(signal_of(quantity).symbol, fontsize=9)
    return figure, by_quantity


def name_axes(panels: Mapping[str, Axes], x: str, y: str) -> None:
    """Names on the lowest panel of each column and on the left ones; numbers of x, which all share, only there."""
    in_order = list(panels.values())
    for axes in in_order[:-_COLUMNS]:
        axes.tick_params(labelbottom=False)
    for axes in in_order[-_COLUMNS:]:
        axes.set_xlabel(x)
    for axes in in_order[::_COLUMNS]:
        axes.set_ylabel(y)


def error_scale(axes: Axes) -> None:
    """A logarithmic scale for the errors that are drawn, or words where there are none."""
    lines = [line for line in axes.lines if line.get_transform() == axes.transData]
    if any((np.asarray(line.get_ydata(), dtype=float) > 0).any() for line in lines):
        axes.set_yscale("log")
        number(axes.yaxis, *axes.get_ylim())
    else:
        say_nothing(axes)


def say_nothing(axes: Axes) -> None:
    """Words in the place of what is not there."""
    axes.text(0.5, 0.5, "no numbers", transform=axes.transAxes, ha="center", va="center")


def scale(axes: Axes, direction: str, values: Array, room: int = _ROOM_ACROSS) -> None:
    """Logarithmic where the values are; `direction` is x or y, `room` how many numbers fit along it."""
    if logarithmic(values):
        (axes.set_xscale if direction == "x" else axes.set_yscale)("log")
        axis = axes.xaxis if direction == "x" else axes.yaxis
        number(axis, float(values.min()), float(values.max()), room)
    elif direction == "x":
        axes.xaxis.set_major_locator(MaxNLocator(room, steps=_STEPS))


def edges(values: Array) -> Array:
    """The edges of the cells around some values, halfway in the scale of the axis."""
    to, back = (np.log, np.exp) if logarithmic(values) else (np.asarray, np.asarray)
    centres = to(values)
    middle = (centres[1:] + centres[:-1]) / 2
    return np.asarray(back(np.r_[2 * centres[0] - middle[0], middle, 2 * centres[-1] - middle[-1]]))


def number(axis: Axis, low: float, high: float, room: int = _ROOM_UP) -> None:
    """Numbers on a logarithmic axis: as many powers of ten and numbers between them as there is room for."""
    powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    powers_alone = [powers[::step] for step in range(2, len(powers) + 1)]
    choices = [*(np.outer(powers, between).ravel() for between in _BETWEEN), *powers_alone]
    inside: list[Array] = [
        numbers[(numbers >= low * (1 - _ROUNDING)) & (numbers <= high * (1 + _ROUNDING))] for numbers in choices
    ]
    fitting = next(numbers for numbers in inside if len(numbers) <= room)
    few = len(fitting) < _FEWEST
    axis.set_major_locator(MaxNLocator(room, steps=_STEPS) if few else FixedLocator(fitting.tolist()))
    axis.set_major_formatter(FuncFormatter(lambda value, _: _short(value)))
    axis.set_minor_formatter(NullFormatter())


# relative: a limit that is a round number but for its last bits has its number
_ROUNDING = 1e-9


def _short(value: float) -> str:
    """0.02, or 2 × 10⁻⁵ where that is shorter."""
    if _SHORT[0] <= value < _SHORT[1]:
        return f"{value:g}"
    mantissa, _, exponent = f"{value:.1e}".replace(".0e", "e").partition("e")
    times = "" if mantissa == "1" else rf"{mantissa}\times"
    return rf"${times}10^{{{int(exponent)}}}$"
