"""Error over two swept parameters as colours: the optimum, the scenario's own values, hatches where runs failed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ....observers import label
from ...sweep.optimum import Optimum, failed, medians, own_value, parameters_of, smallest, varied, violated
from .. import style
from ..page import above, settings
from ..symbols import symbol
from .panels import edges, flattened, name_axes, number, panels, say_nothing, scale

# shown by colours; what is larger is near a failure
_DECADES = 3.0
_RIDGE: style.Style = {"color": "white", "linewidth": 0.8}
_OPTIMUM: style.Style = {
    "linestyle": "none", "marker": "o", "markersize": 4, "markerfacecolor": "white", "markeredgecolor": "black",
    "markeredgewidth": 0.6,
}  # fmt: skip
_SMALLEST: style.Style = {**_OPTIMUM, "markerfacecolor": "none", "markeredgecolor": "white", "markeredgewidth": 1.0}
_OWN: style.Style = {
    "linestyle": "none", "marker": "X", "markersize": 7, "markerfacecolor": "#D55E00", "markeredgecolor": "white",
    "markeredgewidth": 0.6,
}  # fmt: skip
_NOTHING = "0.85"
_FAILED: style.Style = {"facecolor": "none", "edgecolor": "0.25", "linewidth": 0, "hatch": "xxxx"}
# a colour that the map has not
_VIOLATED: style.Style = {**_FAILED, "edgecolor": "#EE4444", "hatch": "////"}
# relative
_FLAT = 1e-3


def maps(dataset: xr.Dataset, observer: str, quantities: Sequence[str]) -> Figure:
    """Median RMSE of each quantity over the two parameters that vary in a grid, for one observer."""
    flat, (x, y) = flattened(dataset), varied(dataset)
    errors = medians(flat.sel(observer=observer)).transpose(y, x, "quantity")
    lost = failed(flat).sel(observer=observer).any("seed").transpose(y, x)
    broken = violated(flat, observer).any("condition").transpose(y, x)
    own_values = {path: value for path in (x, y) if (value := own_value(flat, path)) is not None}
    optima: list[Optimum] = []
    with settings():
        figure, by_quantity = panels(quantities)
        for quantity, axes in by_quantity.items():
            median = errors.sel(quantity=quantity)
            _colours(figure, axes, median)
            _hatch(axes, lost, _FAILED)
            _hatch(axes, broken, _VIOLATED)
            ridge = _ridge(flat, median, observer)
            axes.plot([best.values[x] for best in ridge], [best.values[y] for best in ridge], **_RIDGE)
            for best in ridge:
                axes.plot(best.values[x], best.values[y], **(_OPTIMUM if best.inside else _SMALLEST))
            if len(own_values) == 2:
                axes.plot(own_values[x], own_values[y], **_OWN)
            for direction, path in (("x", x), ("y", y)):
                scale(axes, direction, flat[path].values)
            axes.grid(visible=False)
            optima += ridge
        name_axes(by_quantity, symbol(x), symbol(y))
        above(figure, _handles(flat, observer, optima, len(own_values) == 2))
    return figure


def _colours(figure: Figure, axes: Axes, median: xr.DataArray) -> None:
    """The errors on a logarithmic scale; grey where there is no number."""
    numbers = median.values[median.values > 0]
    axes.set_facecolor(_NOTHING)
    least = float(numbers.min(initial=np.inf))
    if not np.isfinite(least):
        say_nothing(axes)
        return
    cut = numbers.max() > least * 10**_DECADES
    # a map of one colour still needs two ends
    most = least * 10**_DECADES if cut else max(float(numbers.max()), least * (1 + _FLAT))
    x, y = (edges(median[path].values) for path in reversed(median.dims))
    mesh = axes.pcolormesh(x, y, median.values, cmap="viridis", norm=LogNorm(least, most), rasterized=True)
    bar = figure.colorbar(mesh, ax=axes, extend="max" if cut else "neither")
    number(bar.ax.yaxis, least, most)
    bar.set_label("median RMSE")


def _hatch(axes: Axes, where: xr.DataArray, look: style.Style) -> None:
    """Hatches over the cells of (y, x) in which something is so."""
    x, y = (edges(where[path].values) for path in reversed(where.dims))
    cells = [
        [(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])]
        for j, i in np.argwhere(where.values).tolist()
    ]
    axes.add_collection(PolyCollection(cells, **look), autolim=False)


def _ridge(flat: xr.Dataset, median: xr.DataArray, observer: str) -> list[Optimum]:
    """Where the error is smallest: one point, or if one parameter is not the observer's one for each of its values."""
    given = [path for path in median.dims if path not in parameters_of(flat, observer)]
    if len(given) == len(median.dims):
        return []
    lines = [median.isel({given[0]: i}) for i in range(median.sizes[given[0]])] if given else [median]
    return [best for line in lines if (best := smallest(flat, line, observer)) is not None]


def _handles(flat: xr.Dataset, observer: str, optima: Sequence[Optimum], own_values: bool) -> list[Artist]:
    seeds = f", {flat.sizes['seed']:,} seeds" if flat.sizes["seed"] > 1 else ""
    handles: list[Artist] = [Patch(label=f"{label(observer)}{seeds}", visible=False)]
    chosen = parameters_of(flat, observer)
    best = f"best {symbol(chosen[0])}" if len(chosen) == 1 else "optimum"
    if any(best.inside for best in optima):
        handles.append(Line2D([], [], label=best, **{**_RIDGE, **_OPTIMUM}))
    if not all(best.inside for best in optima):
        handles.append(Line2D([], [], label="smallest, no optimum", **{**_SMALLEST, "markeredgecolor": "0.35"}))
    if own_values:
        handles.append(Line2D([], [], label="scenario's values", **_OWN))
    if violated(flat, observer).any():
        handles.append(Patch(label="gain condition fails", **_VIOLATED))
    if failed(flat).sel(observer=observer).any():
        handles.append(Patch(label="runs failed", **_FAILED))
    return handles
