"""A search for gains: how it went, and what the gains are worth in runs that it has not seen."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from ...model.symbols import signal_of
from ...observers import label
from . import style
from .page import above, settings

_TRIED: style.Style = {"linestyle": "none", "marker": "o", "markersize": 2, "color": "0.7", "markeredgewidth": 0}
_OWN: style.Style = {"color": "black", "linestyle": (0, (4, 3)), "linewidth": 0.8}
_BEST: style.Style = {"linestyle": "none", "marker": "*", "markersize": 9, "color": "#D55E00", "zorder": 6}
_FRONT: style.Style = {"color": "#0072B2", "linewidth": 1.1, "marker": "o", "markersize": 3}
_OTHER: style.Style = {"linestyle": "none", "marker": "o", "markersize": 3.5, "color": "#0072B2", "fillstyle": "none"}
# of each decade
_TICKS = (1, 1.5, 2, 3, 5, 7)
_FACTOR = "error over that of the scenario's gains"


def search_figure(trials: xr.Dataset, tests: xr.Dataset) -> Figure:
    """The best over the trials, or the front of the first two objectives; beside it the factor of each quantity."""
    with settings():
        figure = Figure(figsize=(style.PAGE, 3.0), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(1, 1.2))
        allowed, best = trials.sel(trial=trials.broken == 0), trials.isel(trial=trials.attrs["best"])
        if trials.sizes["objective"] == 1:
            _course(left, trials)
        else:
            _front(left, allowed, best)
        _tests(right, tests)
        for axis in (left.xaxis, left.yaxis, right.yaxis):
            if axis.get_scale() == "log":
                axis.set_major_locator(LogLocator(subs=_TICKS))
                axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
                axis.set_minor_locator(NullLocator())
        handles = [
            Line2D([], [], label="allowed trial", **_TRIED),
            *([Line2D([], [], label="front", **_FRONT)] if trials.sizes["objective"] > 1 else []),
            Line2D([], [], label=f"tuned {label(trials.attrs['observer'])}, scenario's trajectory", **_BEST),
            Line2D([], [], label="other trajectories", **_OTHER),
            Line2D([], [], label="scenario's gains", **_OWN),
        ]
        above(figure, handles)
        return figure


def _course(axes: Axes, trials: xr.Dataset) -> None:
    factor = np.where(trials.broken.values == 0, trials.factor.values[:, 0], np.inf)
    count, allowed = np.arange(1, len(factor) + 1), np.isfinite(factor)
    axes.plot(count[allowed], factor[allowed], **_TRIED)
    axes.plot(count, np.minimum.accumulate(factor), color=_FRONT["color"])
    axes.plot(trials.attrs["best"] + 1, factor[trials.attrs["best"]], **_BEST)
    axes.axhline(1, **_OWN)
    axes.set_yscale("log")
    # the first generation may be far off
    axes.set_ylim(top=max(2.0, float(np.min(factor)) * 4))
    axes.set_xlabel("trial")
    axes.set_ylabel(f"{_FACTOR},\ntraining runs")


def _front(axes: Axes, allowed: xr.Dataset, best: xr.Dataset) -> None:
    (x, y), names = allowed.factor.values[:, :2].T, allowed.objective.values
    on_front = allowed.front.values
    order = np.argsort(x[on_front])
    axes.plot(x, y, **_TRIED)
    axes.plot(x[on_front][order], y[on_front][order], **_FRONT)
    axes.plot(*best.factor.values[:2], **_BEST)
    for line in (axes.axvline, axes.axhline):
        line(1, **_OWN)
    low, high = (np.array([reduced(side[on_front]) for side in (x, y)]) for reduced in (np.min, np.max))
    for axis, least, most, name in zip("xy", low, high, names, strict=False):
        symbols = ", ".join(signal_of(quantity).symbol for quantity in name.split(", "))
        axes.set(**{f"{axis}scale": "log", f"{axis}lim": (least / 1.2, max(most, 1.0) * 1.5)})
        axes.set(**{f"{axis}label": f"{_FACTOR}: {symbols}"})


def _tests(axes: Axes, tests: xr.Dataset) -> None:
    own, tuned = tests.rmse.values
    factor = np.median(tuned / own, axis=1)
    place = np.arange(factor.shape[1])
    for of_trajectory in factor[1:]:
        axes.plot(place, of_trajectory, **_OTHER)
    axes.plot(place, factor[0], **_BEST)
    axes.axhline(1, **_OWN)
    axes.set_yscale("log")
    axes.set_xticks(place, [signal_of(name).symbol for name in tests.quantity.values.tolist()])
    axes.set_ylabel(f"{_FACTOR},\nmedian of the test runs")
