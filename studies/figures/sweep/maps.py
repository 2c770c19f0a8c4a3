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

from ....model.arrays import Array
from ....observers import label
from ...sweep.optimum import failed, free, logarithmic, medians, own_value
from .. import style
from ..page import settings
from .panels import flattened, name_axes, panels, say_nothing, scale, varied

# shown by colours; what is larger is near a failure
_DECADES = 3.0
_OPTIMUM: style.Style = {
    "color": "white", "linewidth": 0.8, "marker": "o", "markersize": 4, "markeredgecolor": "black",
    "markeredgewidth": 0.6,
}  # fmt: skip
_OWN: style.Style = {
    "linestyle": "none", "marker": "X", "markersize": 7, "markerfacecolor": "#D55E00", "markeredgecolor": "white",
    "markeredgewidth": 0.6,
}  # fmt: skip
_NOTHING = "0.85"
_HATCHED: style.Style = {"facecolor": "none", "edgecolor": "0.25", "linewidth": 0, "hatch": "xxxx"}
# relative
_FLAT = 1e-3


def maps(dataset: xr.Dataset, observer: str, quantities: Sequence[str]) -> Figure:
    """Median RMSE of each quantity over the two parameters that vary in a grid, for one observer."""
    flat, (x, y) = flattened(dataset), varied(dataset)
    every = medians(flat).sel(observer=observer).transpose(y, x, "quantity")
    lost = failed(flat).sel(observer=observer).any("seed").transpose(y, x)
    own = {path: value for path in (x, y) if (value := own_value(flat, path)) is not None}
    sought = [path for path in (x, y) if path in free(flat, observer)]
    with settings():
        figure, found = panels(quantities)
        for quantity, axes in found.items():
            median = every.sel(quantity=quantity)
            _colours(figure, axes, median)
            _hatch(axes, lost)
            axes.plot(*_optima(median, sought), **_OPTIMUM)
            if len(own) == 2:
                axes.plot(own[x], own[y], **_OWN)
            for direction, path in (("x", x), ("y", y)):
                scale(axes, direction, flat[path].values)
            axes.grid(visible=False)
        name_axes(found, x, y)
        figure.legend(handles=_handles(flat, observer, sought, len(own) == 2), loc="outside upper center", ncols=4)
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
    norm = LogNorm(least, least * 10**_DECADES if cut else max(float(numbers.max()), least * (1 + _FLAT)))
    x, y = (_edges(median[path].values) for path in reversed(median.dims))
    mesh = axes.pcolormesh(x, y, median.values, cmap="viridis", norm=norm, rasterized=True)
    figure.colorbar(mesh, ax=axes, extend="max" if cut else "neither").set_label("median RMSE [1]")


def _hatch(axes: Axes, lost: xr.DataArray) -> None:
    """Hatches over the cells where a run failed."""
    x, y = (_edges(lost[path].values) for path in reversed(lost.dims))
    cells = [
        [(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])]
        for j, i in np.argwhere(lost.values).tolist()
    ]
    axes.add_collection(PolyCollection(cells, **_HATCHED), autolim=False)


def _optima(median: xr.DataArray, sought: Sequence[str]) -> tuple[list[float], list[float]]:
    """Where the error is smallest: one point, or if one parameter is not sought a point for each of its values."""
    given = [path for path in median.dims if path not in sought]
    if len(given) == len(median.dims):
        return [], []
    every = [median.isel({given[0]: i}) for i in range(median.sizes[given[0]])] if given else [median]
    found = [one.isel({dim: int(i) for dim, i in one.argmin(...).items()}) for one in every if one.notnull().any()]
    y, x = ([float(one[path]) for one in found] for path in median.dims)
    return x, y


def _edges(values: Array) -> Array:
    """The edges of the cells around some values, halfway in the scale of the axis."""
    to, back = (np.log, np.exp) if logarithmic(values) else (np.asarray, np.asarray)
    centres = to(values)
    middle = (centres[1:] + centres[:-1]) / 2
    return np.asarray(back(np.r_[2 * centres[0] - middle[0], middle, 2 * centres[-1] - middle[-1]]))


def _handles(flat: xr.Dataset, observer: str, sought: Sequence[str], own: bool) -> list[Artist]:
    seeds = f", {flat.sizes['seed']:,} seeds" if flat.sizes["seed"] > 1 else ""
    handles: list[Artist] = [Patch(label=f"{label(observer)}{seeds}", visible=False)]
    if sought:
        best = "optimum" if len(sought) > 1 else f"best {sought[0]}"
        handles.append(Line2D([], [], label=best, **_OPTIMUM))
    if own:
        handles.append(Line2D([], [], label="scenario's values", **_OWN))
    if failed(flat).sel(observer=observer).any():
        handles.append(Patch(label="runs failed", **_HATCHED))
    return handles
