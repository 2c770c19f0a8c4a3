"""Error over each of many swept parameters: the points of a design, of pairs, or of a grid with more than two axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ....model.symbols import SIGNALS
from ....observers import label
from ...sweep.optimum import axes_of, medians, own_value
from .. import style
from ..page import settings
from .panels import OWN, error_scale, scale, varied

_ROW, _AROUND = 1.4, 0.8  # inches


def scatter(dataset: xr.Dataset, quantities: Sequence[str]) -> Figure:
    """Median RMSE of each quantity at each point, a row per quantity and a column per parameter that varies."""
    paths, axes_ = varied(dataset), axes_of(dataset)
    values = dict(zip(axes_.paths, axes_.at(np.arange(int(np.prod(axes_.shape)))).T, strict=True))
    every, looks = medians(dataset), style.observer_styles(dataset.observer.values.tolist())
    with settings():
        figure = Figure(figsize=(style.PAGE, _AROUND + _ROW * len(quantities)), layout="constrained")
        rows = figure.subplots(len(quantities), len(paths), sharex="col", sharey="row", squeeze=False)
        for quantity, row in zip(quantities, rows, strict=True):
            for path, axes in zip(paths, row, strict=True):
                for observer, look in looks.items():
                    median = every.sel(observer=observer, quantity=quantity).values.ravel()
                    axes.plot(values[path], median, ".", color=look["color"], markersize=3, rasterized=True)
                if (own := own_value(dataset, path)) is not None:
                    axes.axvline(own, **OWN)
                scale(axes, "x", np.unique(values[path]))
                error_scale(axes)
            row[0].set_ylabel(f"RMSE of {SIGNALS[quantity].symbol}")
        for path, axes in zip(paths, rows[-1], strict=True):
            axes.set_xlabel(path)
        handles = [
            Line2D([], [], label=label(name), color=look["color"], marker=".", linestyle="none")
            for name, look in looks.items()
        ]
        if any(own_value(dataset, path) is not None for path in paths):
            handles.append(Line2D([], [], label="scenario's value", **OWN))
        figure.legend(handles=handles, loc="outside upper center", ncols=len(handles))
    return figure
