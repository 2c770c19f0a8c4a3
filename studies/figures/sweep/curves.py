"""Error over one swept parameter: median and spread over the seeds, the optimum, the scenario's own value."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ....model.arrays import Array
from ....observers import label
from ...sweep.optimum import SPREAD, Optimum, errors, failed, medians, optimum, own_value, varied, violated
from .. import style
from ..page import above, settings
from ..symbols import symbol
from .panels import OPTIMUM, OWN, SMALLEST, edges, error_scale, flattened, name_axes, panels, scale

_CLEAN: style.Style = {"color": "black", "linestyle": (0, (4, 3)), "linewidth": 0.9}
_FAILED: style.Style = {"linestyle": "none", "marker": "x", "markersize": 4, "clip_on": False, "zorder": 6}
_VIOLATED: style.Style = {"facecolor": "none", "hatch": "////", "linewidth": 0, "alpha": 0.5, "zorder": 0.5}


def curves(dataset: xr.Dataset, quantities: Sequence[str], clean: xr.Dataset | None = None) -> Figure:
    """RMSE of each quantity over the one parameter that varies in a grid; `clean`: the same sweep without noise."""
    (path,) = varied(dataset)
    flat = flattened(dataset)
    optima: list[Optimum] = []
    with settings():
        figure, by_quantity = panels(quantities)
        for quantity, axes in by_quantity.items():
            for observer, look in style.observer_styles(dataset.observer.values.tolist()).items():
                _violations(axes, flat, observer, look)
                optima += _line(axes, flat, observer, quantity, look)
                if clean is not None:
                    median = medians(flattened(clean).sel(observer=observer, quantity=quantity))
                    axes.plot(median[path].values, median.values, **_CLEAN)
            if (value := own_value(dataset, path)) is not None:
                axes.axvline(value, **OWN)
            scale(axes, "x", flat[path].values)
            error_scale(axes)
        name_axes(by_quantity, symbol(path), "RMSE")
        above(figure, _handles(flat, path, optima, clean is not None))
    return figure


def _violations(axes: Axes, flat: xr.Dataset, observer: str, look: style.Style) -> None:
    """Hatches where a gain condition of the observer does not hold."""
    (path,) = varied(flat)
    broken, values = violated(flat, observer).any("condition"), flat[path].values
    ends = np.clip(edges(values), values.min(), values.max())
    for i in np.flatnonzero(broken.values):
        axes.axvspan(ends[i], ends[i + 1], edgecolor=look["color"], **_VIOLATED)


def _line(axes: Axes, flat: xr.Dataset, observer: str, quantity: str, look: style.Style) -> list[Optimum]:
    """One observer's median, the spread, the optimum if there is one, and crosses above where runs failed."""
    (path,), scored = varied(flat), flat.sel(observer=observer, quantity=quantity)
    values, median = flat[path].values, medians(scored)
    axes.plot(values, median.values, **look)
    if flat.sizes["seed"] > 1:
        # the nearest rank: nothing is interpolated between a number and a failure
        low, high = (_finite(errors(scored).quantile(share, "seed", method="nearest")) for share in SPREAD)
        axes.fill_between(values, low, high, color=look["color"], alpha=0.25, linewidth=0)
    best = optimum(flat, median, observer)
    if best is not None:
        mark = OPTIMUM if best.inside else SMALLEST
        axes.plot(best.values[path], best.error, color=look["color"], **mark, zorder=6)
    lost = values[failed(scored).any("seed").values]
    if lost.size:
        axes.plot(lost, np.ones_like(lost), color=look["color"], transform=axes.get_xaxis_transform(), **_FAILED)
    return [] if best is None else [best]


def _finite(values: xr.DataArray) -> Array:
    return np.where(np.isfinite(values.values), values.values, np.nan)


def _handles(flat: xr.Dataset, path: str, optima: Sequence[Optimum], clean: bool) -> list[Artist]:
    observers = style.observer_styles(flat.observer.values.tolist())
    handles: list[Artist] = [Line2D([], [], label=label(name), **look) for name, look in observers.items()]
    if flat.sizes["seed"] > 1:
        handles.append(Patch(label="⅔ of the seeds", facecolor="0.5", alpha=0.35))
    if clean:
        handles.append(Line2D([], [], label="without noise", **_CLEAN))
    if any(best.inside for best in optima):
        handles.append(Line2D([], [], label="optimum", color="0.35", **OPTIMUM))
    if not all(best.inside for best in optima):
        handles.append(Line2D([], [], label="smallest, no optimum", color="0.35", **SMALLEST))
    if any(violated(flat, name).any() for name in observers):
        handles.append(Patch(label="gain condition fails", edgecolor="0.35", **_VIOLATED))
    if own_value(flat, path) is not None:
        handles.append(Line2D([], [], label="scenario's value", **OWN))
    if failed(flat).any():
        handles.append(Line2D([], [], label="runs failed", color="0.35", **_FAILED))
    return handles
