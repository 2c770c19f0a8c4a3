"""What the figures of a sweep share: a panel per quantity, scales that fit the values, the marks' looks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ....model.arrays import Array
from ....model.symbols import SIGNALS
from ...sweep.optimum import axes_of, logarithmic
from .. import style

OPTIMUM: style.Style = {"linestyle": "none", "marker": "o", "markersize": 5}
OWN: style.Style = {"color": "0.35", "linestyle": (0, (1, 2)), "linewidth": 1.0}

_COLUMNS = 2
_ROW, _LONE_ROW, _AROUND = 1.7, 2.5, 0.8  # inches
# up to so many powers of ten an axis has room for numbers between them
_FEW_DECADES = 2.5


def varied(dataset: xr.Dataset) -> list[str]:
    """The swept parameters with more than one value."""
    axes = axes_of(dataset)
    return [path for path, values in zip(axes.paths, axes.values, strict=True) if len(np.unique(values)) > 1]


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
    found = dict(zip(quantities, figure.axes, strict=True))
    for quantity, axes in found.items():
        axes.set_title(SIGNALS[quantity].symbol, fontsize=9)
    return figure, found


def name_axes(panels: Mapping[str, Axes], x: str, y: str) -> None:
    """Names on the lowest panel of each column and on the left ones; numbers of x, which all share, only there."""
    every = list(panels.values())
    for axes in every[:-_COLUMNS]:
        axes.tick_params(labelbottom=False)
    for axes in every[-_COLUMNS:]:
        axes.set_xlabel(x)
    for axes in every[::_COLUMNS]:
        axes.set_ylabel(y)


def error_scale(axes: Axes) -> None:
    """A logarithmic scale for the errors that are drawn, or words where there are none."""
    lines = [line for line in axes.lines if line.get_transform() == axes.transData]
    if any((np.asarray(line.get_ydata(), dtype=float) > 0).any() for line in lines):
        axes.set_yscale("log")
    else:
        say_nothing(axes)


def say_nothing(axes: Axes) -> None:
    """Words in the place of what is not there."""
    axes.text(0.5, 0.5, "no numbers", transform=axes.transAxes, ha="center", va="center")


def scale(axes: Axes, direction: str, values: Array) -> None:
    """Logarithmic where the values are, with plain numbers where there is room; `direction` is x or y."""
    axis = axes.xaxis if direction == "x" else axes.yaxis
    if logarithmic(values):
        (axes.set_xscale if direction == "x" else axes.set_yscale)("log")
        axis.set_minor_formatter(NullFormatter())
        if np.log10(values.max() / values.min()) < _FEW_DECADES:
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
