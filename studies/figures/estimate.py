"""A sheet of what was measured, what was estimated, and what the measurements still disagree with."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from ...model.arrays import Array
from ...observers import label
from ..estimate.dataset import ON_PAPER, joint_units
from ..estimate.scores import SETTLED, WITHIN_95
from ..files.quote import drawn
from . import style
from .page import above, settings
from .traces import line, with_margin

# points of a line that a page can show
_MOST_POINTS = 4000
# inches: a panel, and one that is looked at most
_ROW, _TALL = 0.85, 1.3
# letters of a name that are as long as an inch, standing beside a panel
_LETTERS = 12
# of the range of the values, above and below them
_MARGIN = 0.08
# observers side by side; further ones stand below, as evenly as can be
_MOST_COLUMNS = 4
# observers have colours, what was measured has none: a dark and a light line with each of the dashes, and of still more
# lines thicker ones; dashes that differ at a glance, in a noisy line too
_GREYS = ("0.25", "0.65")
_DASHES: tuple[Any, ...] = (
    "-",
    (0, (8, 6)),
    (0, (1.5, 3)),
    (0, (12, 4, 1.5, 4)),
    (0, (20, 6)),
    (0, (8, 3, 1.5, 3, 1.5, 3)),
)
_THICKER = 2.0
# names beside each other above a panel; inches that they may take, those of a further row of them, and those by which
# the margin of the last row is over the panel
_NAMES, _WIDE, _LINE, _OVER = 6, 6.2, 0.14, 0.0425
# a scale of its own for an observer with values so many times as large as the usual one has
_HIDES = 8.0
# along a panel
_NUMBERS = 5
# deviations that are drawn: the first that an observer tells, with noise or without
_DEVIATIONS = ("_sd", "_sd_muscle")


@dataclass(frozen=True)
class Panel:
    """What one panel shows: a variable of the Dataset, its words on paper, and the factor to the unit there."""

    variable: str
    words: str
    factor: float = 1.0
    muscle: int | str = ""  # empty where the variable has none
    joint: str = ""
    true: str = ""
    height: float = _ROW
    limits: tuple[float, float] | None = None  # those of the values if None


_ACTIVATION = (-0.03, 1.03)
# a sheet of more muscles shows what they do, and not each length and each error
_MOST_IN_FULL = 2


def _on_paper(unit: str) -> tuple[str, float]:
    return ON_PAPER.get(unit, (unit, 1.0))


def _units(thin: xr.Dataset, variable: str) -> dict[str, str]:
    """The unit of each joint's part of a variable; a pair's joint has no name."""
    return joint_units(thin, variable) if "joint" in thin.dims else {"": thin[variable].attrs["units"]}


def _wrapped(name: int | str, inches: float) -> str:
    """A name in lines that are no longer than its panel is high, if they can end behind a _ with one."""
    # textwrap ends lines behind hyphens, which names do not have
    lines = textwrap.wrap(str(name).replace("_", "-"), int(inches * _LETTERS))
    return "\n".join(lines).replace("-", "_")


def _panels(thin: xr.Dataset) -> list[Panel]:
    """What the sheet shows, from activations down to what an observer leaves unexplained."""
    muscles = thin.muscle.values.tolist()
    # a pair's names are short, and stand beside words; others stand below
    below, unit_of = ("\n", "\n") if "joint" in thin.dims else (" ", ", ")

    def of_joints(variable: str, words: str, alone: str = "", true: str = "") -> list[Panel]:
        return [
            Panel(variable, f"{words}\n{name}{unit_of if name else ''}{unit}", factor, joint=joint, true=true)
            for joint, own in _units(thin, variable).items()
            # nobody knows what moves a prescribed joint
            if not joint or thin[variable].sel(joint=joint).notnull().any()
            for name in [_wrapped(joint, _ROW) or alone]
            for unit, factor in [_on_paper(own)]
        ]

    def of_muscles(variable: str, words: str, true: str = "", unit: str = "", height: float = _ROW) -> list[Panel]:
        before = unit_of if "\n" in words else "\n"
        tail, factor = (before + unit, 1e3) if unit else ("", 1.0)
        return [
            Panel(variable, f"{words}{below}{_wrapped(muscle, height)}{tail}", factor, muscle, true=true, height=height)
            for muscle in muscles
        ]

    full = len(muscles) <= _MOST_IN_FULL
    activations = of_muscles("activation_hat", "activation", "true_activation", height=_TALL)
    return [
        *(replace(panel, limits=_ACTIVATION) for panel in activations),
        *of_joints("velocity_hat", "velocity", true="true_velocity"),
        *(of_muscles("fibre_length_hat", "fibre", "true_fibre_length", "mm") if full else ()),
        *of_joints("disturbance_hat", "external", "force", "true_disturbance"),
        # where the truth is known
        *(of_muscles("activation_error", "error of\nactivation") if full and "activation_error" in thin else ()),
        # what an observer leaves unexplained
        *of_joints("position_innovation", "innovation", "position"),
        *(of_muscles("tendon_innovation", "innovation\ntendon", unit="mm") if full else ()),
    ]


def estimate_sheet(dataset: xr.Dataset) -> Figure:
    """Position and forces, and below them for each observer a column of panels, beside the truth if it is known.

    In one panel observers that are all right would lie on each other, noise on noise. A row has one scale, unless one
    observer would hide the others. The same estimates give the same bytes.
    """
    thin = dataset.isel(time=slice(None, None, -(-dataset.sizes["time"] // _MOST_POINTS)))
    if "true_activation" in thin:
        thin = thin.assign(activation_error=thin.activation_hat - thin.true_activation)
    shown = _panels(thin)
    observers = thin.observer.values.tolist()
    tiers = -(-len(observers) // _MOST_COLUMNS)
    columns = -(-len(observers) // tiers)
    # position and forces, of which many need height to be told apart
    measured = (_ROW, _ROW if thin.sizes["muscle"] <= _MOST_IN_FULL else _TALL)
    heights = [*measured, *[panel.height for panel in shown] * tiers]
    with settings():
        figure = Figure(figsize=(style.PAGE, sum(heights)), layout="constrained")
        grid = figure.add_gridspec(len(heights), columns, height_ratios=heights)
        upper, lower = (figure.add_subplot(grid[row, :]) for row in range(len(measured)))
        # names above the first panels take no height from them
        figure.set_figheight(sum(heights) + _LINE * _measured(figure, upper, lower, thin, measured))
        limits = [_limits(thin, panel) for panel in shown]
        for place, (name, look) in enumerate(style.observer_colours(observers).items()):
            tier, column = divmod(place, columns)
            left = observers[place - 1] if column else ""
            for row, (panel, scale) in enumerate(zip(shown, limits, strict=True)):
                axes = figure.add_subplot(grid[len(measured) + tier * len(shown) + row, column])
                axes.set_ylim(scale[name])
                _shade(axes, thin, panel, name, look)
                _draw(axes, thin, panel, name, look)
                if row == 0:
                    axes.set_title(drawn(label(name)), color=look["color"])
                # words and numbers once for a row and for a column
                if not left:
                    axes.set_ylabel(panel.words)
                axes.tick_params(labelleft=scale.get(left) != scale[name], labelbottom=row == len(shown) - 1)
            axes.set_xlabel("time, s")
        for axes in figure.axes:
            _set_time(axes, thin)
        figure.align_ylabels([axes for axes in figure.axes if axes.get_ylabel()])
        handles: list[Artist] = []
        if any(panel.true in thin for panel in shown):
            handles.append(Line2D([], [], label="true", **style.TRUE))
        if parts := {name: part for panel in shown for name in observers if (part := _told(thin, panel, name))}:
            noiseless = ", ".join(label(name) for name, part in parts.items() if part != _DEVIATIONS[0])
            words = "95 %" + (f", without noise for {drawn(noiseless)}" if noiseless else "")
            handles.append(Patch(label=words, **style.sure({"color": "0.3"})))
        if handles:
            above(figure, handles)
    return figure


def _measured(figure: Figure, upper: Axes, lower: Axes, thin: xr.Dataset, heights: tuple[float, float]) -> int:
    """Positions and forces, each line with its name where there are several; how many more rows names take than one."""
    units = _units(thin, "position")
    alike = len(set(units.values())) == 1
    unit, factor = _on_paper(next(iter(units.values()))) if alike else ("", 1.0)
    positions = np.atleast_2d((thin.position.values * factor).T)
    for values, look, (joint, own) in zip(positions, _greys(len(positions)), units.items(), strict=True):
        upper.plot(thin.time.values, values, **look, label=joint if alike else f"{joint}, {own}")
    upper.set_ylabel(f"position\n{unit}" if alike else "position")
    upper.tick_params(labelbottom=False)
    muscles = thin.muscle.values.tolist()
    words = "{}" if "joint" in thin.dims else "tendon {}"
    for muscle, look in zip(muscles, _greys(len(muscles), thin=True), strict=True):
        lower.plot(thin.time.values, thin.force.sel(muscle=muscle).values, **look, label=words.format(muscle))
    lower.set_ylabel("force\nN")
    lines = zip((upper, lower), (len(units), len(muscles)), heights, strict=True)
    return sum(_name(figure, axes, count, height) - 1 for axes, count, height in lines if count > 1)


def _name(figure: Figure, axes: Axes, count: int, height: float) -> int:
    """Name so many lines above their panel of this height, not over the data; in how many rows."""
    top = (1, 1 - _OVER / height)
    for columns in range(min(count, _NAMES), 0, -1):
        legend = axes.legend(loc="lower right", bbox_to_anchor=top, ncols=columns, borderaxespad=0, labelspacing=0)
        if legend.get_window_extent().width <= _WIDE * figure.dpi:
            break
    return -(-count // columns)


def _greys(count: int, thin: bool = False) -> list[style.Style]:
    """Lines of what was measured, which has no colour."""
    several = len(_GREYS) * len(_DASHES)
    return [
        {
            "color": _GREYS[i % len(_GREYS)],
            "linewidth": (0.6 if thin else 0.8) * (_THICKER if i >= several else 1.0),
            "linestyle": _DASHES[i // len(_GREYS) % len(_DASHES)],
        }
        for i in range(count)
    ]


def _draw(axes: Axes, thin: xr.Dataset, panel: Panel, observer: str, look: style.Style) -> None:
    """What one panel shows of one observer, with the truth if it is known."""
    time = thin.time.values
    line(axes, time, _of(thin, panel, panel.variable).sel(observer=observer), look, observer)
    if panel.true in thin:
        axes.plot(time, _of(thin, panel, panel.true), **style.TRUE)


def _of(thin: xr.Dataset, panel: Panel, variable: str) -> xr.DataArray:
    """A variable of the Dataset as the panel shows it."""
    array = thin[variable] * panel.factor
    of = {name: label for name, label in (("muscle", panel.muscle), ("joint", panel.joint)) if label != ""}
    return array.sel(of)


def _limits(thin: xr.Dataset, panel: Panel) -> dict[str, tuple[float, float]]:
    """Limits for each observer: those that fit all which do not fail, or its own for one that would hide the others."""
    names = thin.observer.values.tolist()
    if panel.limits:
        return dict.fromkeys(names, panel.limits)
    estimates = _of(thin, panel, panel.variable)
    true = [_settled(_of(thin, panel, panel.true))] if panel.true in thin else []
    values = {name: np.concatenate([_settled(estimates.sel(observer=name)), *true]) for name in names}
    # what fails ends without bounds
    whole = [name for name in names if estimates.sel(observer=name).notnull().all()] or names
    sizes = {name: np.abs(values[name]).max(initial=0.0) for name in whole}
    usual = sorted(sizes.values())[(len(sizes) - 1) // 2]
    together = [name for name in whole if sizes[name] <= _HIDES * usual]
    common = with_margin(np.concatenate([values[name] for name in together]), _MARGIN)
    apart = {name: with_margin(values[name], _MARGIN) for name in whole if name not in together}
    return {**dict.fromkeys(names, common), **apart}


def _told(thin: xr.Dataset, panel: Panel, observer: str) -> str:
    """Which of the deviations an observer tells of what a panel shows, or an empty text."""
    names = {part: panel.variable.removesuffix("_hat") + part for part in _DEVIATIONS}
    known = (p for p, name in names.items() if name in thin and thin[name].sel(observer=observer).notnull().any())
    return next(known, "")


def _shade(axes: Axes, thin: xr.Dataset, panel: Panel, observer: str, look: style.Style) -> None:
    """Where, with 95 %, what an observer estimates is, if it tells that."""
    if part := _told(thin, panel, observer):
        name = panel.variable.removesuffix("_hat") + part
        middle, deviation = (_of(thin, panel, of).sel(observer=observer).values for of in (panel.variable, name))
        width = WITHIN_95 * deviation
        axes.fill_between(thin.time.values, middle - width, middle + width, label="95 %", **style.sure(look))


def _settled(array: xr.DataArray) -> Array:
    """The finite values after observers have settled, or all of a short recording."""
    late = array.sel(time=slice(float(array.time[0]) + SETTLED, None))
    values: Array = (late if late.sizes["time"] else array).values
    return values[np.isfinite(values)]


def _set_time(axes: Axes, thin: xr.Dataset) -> None:
    """The time of the recording, slack tendons and bridged gaps in it as grey bands."""
    time = thin.time.values
    axes.set_xlim(time[0], time[-1] if len(time) > 1 else None)
    axes.xaxis.set_major_locator(MaxNLocator(_NUMBERS, steps=[1, 2, 5, 10]))
    grey = (thin.slack.values > 0).any(axis=1) | (thin.bridged.values > 0)
    if grey.any():
        axes.fill_between(time, 0, 1, where=grey, transform=axes.get_xaxis_transform(), **style.SLACK)
