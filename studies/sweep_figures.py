"""The curves of a sweep: error over one parameter, noise-free and noisy, the optimum and the default marked."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ..model.symbols import SIGNALS
from . import style
from .figures import settings

_SHOWN = ("x2", "Delta", "u1", "a1")
# of the seeds, the middle two thirds
_SPREAD = (1 / 6, 5 / 6)


def trade_off(clean: xr.Dataset, noisy: xr.Dataset) -> Figure:
    """RMSE of x₂, Δ, u₁ and a₁ over the one parameter that both Datasets sweep, for the one observer in them."""
    (path,) = json.loads(noisy.attrs["axes"])
    (observer,) = noisy.observer.values.tolist()
    line = style.observer_styles([observer])[observer]
    with settings():
        figure = Figure(figsize=(style.PAGE, 4.2), layout="constrained")
        for axes, quantity in zip(figure.subplots(2, 2, sharex=True).flat, _SHOWN, strict=True):
            of = {"observer": observer, "quantity": quantity}
            _panel(axes, path, clean.rmse.sel(of).isel(seed=0), noisy.rmse.sel(of), str(line["color"]))
            default = float(json.loads(noisy.attrs["parameters"])[path])
            axes.axvline(default, color="0.4", linestyle=(0, (1, 2)), linewidth=0.9, label="default")
            axes.set_title(SIGNALS[quantity].symbol, fontsize=9)
        for axes in figure.axes[2:]:
            axes.set_xlabel(path)
        for axes in figure.axes[::2]:
            axes.set_ylabel("RMSE")
        handles, labels = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _panel(axes: Axes, path: str, clean: xr.DataArray, noisy: xr.DataArray, color: str) -> None:
    values, median = noisy[path].values, noisy.median("seed")
    low, high = (noisy.quantile(share, "seed").values for share in _SPREAD)
    axes.fill_between(values, low, high, color=color, alpha=0.25, linewidth=0, label="with noise: ⅔ of the seeds")
    axes.plot(values, median.values, color=color, label="with noise: median")
    axes.plot(values, clean.values, color="black", linestyle=(0, (4, 3)), linewidth=0.9, label="without noise")
    if bool(median.notnull().any()):
        best = int(np.nanargmin(median.values))
        axes.plot(values[best], median.values[best], "o", color=color, markersize=5, label="optimum")
    axes.set_xscale("log")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_yscale("log")
