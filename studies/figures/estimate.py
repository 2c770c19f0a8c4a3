"""A sheet of what was measured, what was estimated, and what the measurements still disagree with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...model.arrays import Array
from ...observers import label
from ..estimate.scores import SETTLED
from . import style
from .page import settings, write_figures

# points of a line that a page can show
_MOST_POINTS = 4000
# inches: a panel, and one that is looked at most
_ROW, _TALL = 0.95, 1.45
# error lines of several observers lie over each other
_THIN = 0.6
# what is drawn, its words on paper, the factor to its unit, and how high its panel is
_ESTIMATES: Sequence[tuple[str, str, float, float]] = (
    ("activation_1", "activation 1", 1.0, _TALL),
    ("activation_2", "activation 2", 1.0, _TALL),
    ("velocity", "velocity\nmm/s", 1e3, _ROW),
    ("fibre_length_1", "fibre 1\nmm", 1e3, _ROW),
    ("fibre_length_2", "fibre 2\nmm", 1e3, _ROW),
    ("disturbance", "external\nforce, N", 1.0, _ROW),
)
# the error of the activations, where it is known, and what an observer leaves unexplained, both muscles together
_ERROR = ("activation_error", "error of\nactivations", 1.0)
_INNOVATIONS = (
    ("position_innovation", "innovation of\nposition, mm", 1e3),
    ("tendon_innovation", "of tendon\nlengths, mm", 1e3),
)


def estimate_sheet(dataset: xr.Dataset) -> Figure:
    """Position and forces; estimates of each observer beside the truth, if it is known; errors and innovations."""
    thin = dataset.isel(time=slice(None, None, -(-dataset.sizes["time"] // _MOST_POINTS)))
    differences = [*_INNOVATIONS]
    if "true_activation" in thin:
        thin = thin.assign(activation_error=thin.activation_hat - thin.true_activation)
        differences.insert(0, _ERROR)
    looks = style.observer_styles(thin.observer.values.tolist())
    heights = [_ROW, _ROW, *(height for *_, height in _ESTIMATES), *(_ROW for _ in differences)]
    with settings():
        figure = Figure(figsize=(style.PAGE, sum(heights)), layout="constrained")
        axes = list(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights))
        _measured(axes[0], axes[1], thin)
        for panel, (name, words, factor, _) in zip(axes[2:], _ESTIMATES, strict=False):
            _estimates(panel, thin, looks, name, factor)
            panel.set_ylabel(words)
        for panel, (name, words, factor) in zip(axes[2 + len(_ESTIMATES) :], differences, strict=True):
            _differences(panel, thin, looks, name, factor)
            panel.set_ylabel(words)
        axes[-1].set_xlabel("time, s")
        axes[-1].set_xlim(float(thin.time[0]), float(thin.time[-1]) if thin.sizes["time"] > 1 else None)
        _mark(axes, thin)
        figure.align_ylabels(axes)
        handles = [Line2D([], [], label=label(name), **look) for name, look in looks.items()]
        if any(f"true_{name.rstrip('_12')}" in dataset for name, *_ in _ESTIMATES):
            handles.append(Line2D([], [], label="true", **style.TRUE))
        figure.legend(handles=handles, loc="outside upper center", ncols=len(handles))
    return figure


def save_sheet(dataset: xr.Dataset, folder: str | Path, stem: str) -> list[Path]:
    """Write the sheet as `STEM-sheet.png` and `.pdf`; the same estimates give the same bytes."""
    return write_figures({"sheet": estimate_sheet(dataset)}, folder, stem)


def _measured(above: Axes, below: Axes, thin: xr.Dataset) -> None:
    above.plot(thin.time.values, thin.position.values * 1e3, color="black", linewidth=0.8)
    above.set_ylabel("position\nmm")
    for j, look in zip((1, 2), style.lines(["1", "2"]).values(), strict=True):
        below.plot(thin.time.values, thin.force.sel(muscle=j).values, **{**look, "linewidth": 0.9}, label=f"tendon {j}")
    below.set_ylabel("force\nN")
    # above its panel, not over the data
    below.legend(loc="lower right", bbox_to_anchor=(1, 0.95), ncols=2, borderaxespad=0, labelspacing=0)


def _estimates(axes: Axes, thin: xr.Dataset, looks: Mapping[str, style.Style], name: str, factor: float) -> None:
    base, _, muscle = name.rpartition("_") if name[-1] in "12" else (name, "", "")

    def of(variable: str) -> xr.DataArray:
        found = thin[variable] * factor
        return found.sel(muscle=int(muscle)) if muscle else found

    estimates = of(f"{base}_hat")
    for observer, look in looks.items():
        axes.plot(thin.time.values, estimates.sel(observer=observer).values, **look)
    shown = [_settled(estimates)]
    if f"true_{base}" in thin:
        true = of(f"true_{base}")
        shown.append(_settled(true))
        axes.plot(thin.time.values, true.values, **style.TRUE)
    if base == "activation":
        axes.set_ylim(-0.03, 1.03)
    else:
        _fit(axes, np.concatenate(shown))


def _differences(axes: Axes, thin: xr.Dataset, looks: Mapping[str, style.Style], name: str, factor: float) -> None:
    for observer, look in looks.items():
        # (time), or (time × muscle)
        axes.plot(thin.time.values, thin[name].sel(observer=observer).values * factor, **{**look, "linewidth": _THIN})
    _fit(axes, _settled(thin[name] * factor))


def _settled(array: xr.DataArray) -> Array:
    """The finite values after observers have found in, or all of a short recording."""
    late = array.sel(time=slice(float(array.time[0]) + SETTLED, None))
    values: Array = (late if late.sizes["time"] else array).values
    return values[np.isfinite(values)]


def _fit(axes: Axes, values: Array) -> None:
    """Limits that hold what came after the first, maybe wild, moments."""
    if values.size and (height := np.ptp(values)) > 0:
        axes.set_ylim(values.min() - 0.08 * height, values.max() + 0.08 * height)


def _mark(axes: Sequence[Axes], thin: xr.Dataset) -> None:
    """Slack tendons and bridged gaps as grey bands."""
    grey = (thin.slack.values > 0).any(axis=1) | (thin.bridged.values > 0)
    if grey.any():
        for panel in axes:
            panel.fill_between(thin.time.values, 0, 1, where=grey, transform=panel.get_xaxis_transform(), **style.SLACK)
