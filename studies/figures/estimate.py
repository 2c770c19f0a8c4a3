"""A sheet of what was measured, what was estimated, and what the measurements still disagree with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ...model.arrays import Array
from ...observers import label
from ..estimate.scores import SETTLED, WITHIN_95
from . import style
from .page import above, settings, write_figures
from .traces import traces, with_margin

# what the figure is called
SHEET = "sheet"
# points of a line that a page can show
_MOST_POINTS = 4000
# inches: a panel, and one that is looked at most
_ROW, _TALL = 0.85, 1.3
# of the range of the values, above and below them
_MARGIN = 0.08
# deviations that are drawn: the first that is known
_WHOLE, _MUSCLE = "_sd", "_sd_muscle"
_WHOLE_OF = f"position{_WHOLE}"
# two noisy lines in one panel
_MEASURED: style.Style = {"linestyle": "-", "linewidth": 0.6}


@dataclass(frozen=True)
class Panel:
    """What one panel shows: a variable of the Dataset, its words on paper, and the factor to the unit there."""

    variable: str
    words: str
    factor: float = 1.0
    muscle: int = 0  # 0 where the variable has none
    true: str = ""
    height: float = _ROW
    limits: tuple[float, float] | None = None  # those of the values if None


_ACTIVATION = (-0.03, 1.03)
_PANELS = (
    Panel("activation_hat", "activation 1", 1.0, 1, "true_activation", _TALL, _ACTIVATION),
    Panel("activation_hat", "activation 2", 1.0, 2, "true_activation", _TALL, _ACTIVATION),
    Panel("velocity_hat", "velocity\nmm/s", 1e3, true="true_velocity"),
    Panel("fibre_length_hat", "fibre 1\nmm", 1e3, 1, "true_fibre_length"),
    Panel("fibre_length_hat", "fibre 2\nmm", 1e3, 2, "true_fibre_length"),
    Panel("disturbance_hat", "external\nforce, N", true="true_disturbance"),
    # where the truth is known
    Panel("activation_error", "error of\nactivation 1", 1.0, 1),
    Panel("activation_error", "error of\nactivation 2", 1.0, 2),
    # what an observer leaves unexplained
    Panel("position_innovation", "innovation\nposition, mm", 1e3),
    Panel("tendon_innovation", "innovation\ntendon 1, mm", 1e3, 1),
    Panel("tendon_innovation", "innovation\ntendon 2, mm", 1e3, 2),
)


def estimate_sheet(dataset: xr.Dataset) -> Figure:
    """Position and forces; estimates of each observer beside the truth, if it is known; errors and innovations."""
    thin = dataset.isel(time=slice(None, None, -(-dataset.sizes["time"] // _MOST_POINTS)))
    if "true_activation" in thin:
        thin = thin.assign(activation_error=thin.activation_hat - thin.true_activation)
    shown = [panel for panel in _PANELS if panel.variable in thin]
    looks = style.observer_styles(thin.observer.values.tolist())
    heights = [_ROW, _ROW, *(panel.height for panel in shown)]
    with settings():
        figure = Figure(figsize=(style.PAGE, sum(heights)), layout="constrained")
        axes = list(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights))
        axes[-1].set_xlabel("time, s")
        axes[-1].set_xlim(float(thin.time[0]), float(thin.time[-1]) if thin.sizes["time"] > 1 else None)
        _measured(axes[0], axes[1], thin)
        bands = [_draw(one, thin, panel, looks) for one, panel in zip(axes[2:], shown, strict=True)]
        surest, part = _surest(thin)
        sure_look = style.sure(looks[surest])
        sure = [_shade(one, thin, panel, surest, part, sure_look) for one, panel in zip(axes[2:], shown, strict=True)]
        _mark(axes, thin)
        figure.align_ylabels(axes)
        handles: list[Artist] = [Line2D([], [], label=label(name), **look) for name, look in looks.items()]
        if any(panel.true in thin for panel in shown):
            handles.append(Line2D([], [], label="true", **style.TRUE))
        if any(bands):
            handles.append(Patch(**style.BAND))
        if any(sure):
            words = f"95 % of {label(surest)}" + ("" if part == _WHOLE else ", without noise")
            handles.append(Patch(label=words, **sure_look))
        above(figure, handles)
    return figure


def save_sheet(dataset: xr.Dataset, folder: str | Path, stem: str) -> list[Path]:
    """Write the sheet as `STEM-sheet.png` and `.pdf`; the same estimates give the same bytes."""
    return write_figures({SHEET: estimate_sheet(dataset)}, folder, stem)


def _measured(upper: Axes, lower: Axes, thin: xr.Dataset) -> None:
    upper.plot(thin.time.values, thin.position.values * 1e3, color="black", linewidth=0.8)
    upper.set_ylabel("position\nmm")
    for j, look in zip((1, 2), style.lines(["1", "2"]).values(), strict=True):
        lower.plot(thin.time.values, thin.force.sel(muscle=j).values, **{**look, **_MEASURED}, label=f"tendon {j}")
    lower.set_ylabel("force\nN")
    # above its panel, not over the data
    lower.legend(loc="lower right", bbox_to_anchor=(1, 0.95), ncols=2, borderaxespad=0, labelspacing=0)


def _draw(axes: Axes, thin: xr.Dataset, panel: Panel, looks: Mapping[str, style.Style]) -> bool:
    """One panel, with the truth if it is known; whether noise is drawn as bands."""

    def of(variable: str) -> xr.DataArray:
        array = thin[variable] * panel.factor
        return array.sel(muscle=panel.muscle) if panel.muscle else array

    axes.set_ylabel(panel.words)
    time, estimates = thin.time.values, of(panel.variable)
    values = [_settled(estimates).ravel()]
    if panel.true in thin:
        values.append(_settled(of(panel.true)))
        axes.plot(time, of(panel.true).values, **style.TRUE)
    axes.set_ylim(panel.limits or with_margin(np.concatenate(values), _MARGIN))
    return traces(axes, time, {name: estimates.sel(observer=name).values for name in looks}, looks)


def _surest(thin: xr.Dataset) -> tuple[str, str]:
    """The first observer that tells all of its deviations, else the first of all; which deviations are known of it."""
    for observer in thin.observer.values.tolist():
        if _WHOLE_OF in thin and thin[_WHOLE_OF].sel(observer=observer).notnull().any():
            return observer, _WHOLE
    return str(thin.observer.values[0]), _MUSCLE


def _shade(axes: Axes, thin: xr.Dataset, panel: Panel, observer: str, part: str, look: style.Style) -> bool:
    """Where, with 95 %, what an observer estimates is; whether that is known."""
    name = panel.variable.removesuffix("_hat") + part
    if name not in thin:
        return False
    of = thin[[panel.variable, name]].sel(observer=observer) * panel.factor
    of = of.sel(muscle=panel.muscle) if panel.muscle else of
    middle, width = of[panel.variable].values, WITHIN_95 * of[name].values
    axes.fill_between(thin.time.values, middle - width, middle + width, label="95 %", **look)
    return True


def _settled(array: xr.DataArray) -> Array:
    """The finite values after observers have settled, or all of a short recording."""
    late = array.sel(time=slice(float(array.time[0]) + SETTLED, None))
    values: Array = (late if late.sizes["time"] else array).values
    return values[np.isfinite(values)]


def _mark(axes: Sequence[Axes], thin: xr.Dataset) -> None:
    """Slack tendons and bridged gaps as grey bands."""
    grey = (thin.slack.values > 0).any(axis=1) | (thin.bridged.values > 0)
    if grey.any():
        for panel in axes:
            panel.fill_between(thin.time.values, 0, 1, where=grey, transform=panel.get_xaxis_transform(), **style.SLACK)
