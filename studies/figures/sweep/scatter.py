"""Error over each of many swept parameters: the points of a design, of pairs, or of a grid with more than two axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ....model.symbols import signal_of
from ....observers import label
from ...sweep.optimum import axes_of, medians, own_value, varied, violated
from .. import style
from ..page import above, settings
from ..symbols import symbol
from .panels import OWN, error_scale, scale

_ROW, _AROUND = 1.4, 0.8  # inches
# points of several observers lie over each other
_POINT: style.Style = {"linestyle": "none", "marker": "o", "markersize": 2.4, "markeredgewidth": 0.5, "alpha": 0.7}
_VIOLATED: style.Style = {**_POINT, "markerfacecolor": "none"}
# numbers that all columns of a page have room for, and those that each needs
_ROOM, _FEWEST = 10, 3


def scatter(dataset: xr.Dataset, quantities: Sequence[str]) -> Figure:
    """Median RMSE of each quantity at each point, a row per quantity and a column per parameter that varies."""
    paths, axes_ = varied(dataset), axes_of(dataset)
    values = dict(zip(axes_.paths, axes_.at(np.arange(axes_.size)).T, strict=True))
    errors, looks = medians(dataset), style.observer_styles(dataset.observer.values.tolist())
    broken = {name: violated(dataset, name).any("condition").values.ravel() for name in looks}
    with settings():
        figure = Figure(figsize=(style.PAGE, _AROUND + _ROW * len(quantities)), layout="constrained")
        rows = figure.subplots(len(quantities), len(paths), sharex="col", sharey="row", squeeze=False)
        for quantity, row in zip(quantities, rows, strict=True):
            for path, axes in zip(paths, row, strict=True):
                for observer, look in looks.items():
                    median = errors.sel(observer=observer, quantity=quantity).values.ravel()
                    for point, where in ((_POINT, ~broken[observer]), (_VIOLATED, broken[observer])):
                        axes.plot(values[path][where], median[where], color=look["color"], rasterized=True, **point)
                if (value := own_value(dataset, path)) is not None:
                    axes.axvline(value, **OWN)
                scale(axes, "x", np.unique(values[path]), max(_FEWEST, _ROOM // len(paths)))
                error_scale(axes)
            row[0].set_ylabel(f"RMSE of {signal_of(quantity).symbol}")
        for path, axes in zip(paths, rows[-1], strict=True):
            axes.set_xlabel(symbol(path))
        above(figure, _handles(dataset, any(where.any() for where in broken.values())))
    return figure


def _handles(dataset: xr.Dataset, broken: bool) -> list[Artist]:
    looks = style.observer_styles(dataset.observer.values.tolist())
    handles: list[Artist] = [Line2D([], [], label=label(o), color=look["color"], **_POINT) for o, look in looks.items()]
    if broken:
        handles.append(Line2D([], [], label="gain condition fails", color="0.35", **_VIOLATED))
    if any(own_value(dataset, path) is not None for path in varied(dataset)):
        handles.append(Line2D([], [], label="scenario's value", **OWN))
    return handles
