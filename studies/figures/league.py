"""The league: what accuracy costs, and who holds where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...model.symbols import signal_of
from ...observers import label
from ..league.gains import SETS
from ..league.lines import BOUND, SMOOTHER
from ..league.play import Entry
from ..scenarios.prepare import BASELINE
from . import style
from .page import above, settings

# of each set of gains
_MARKERS = dict(zip((gains.name for gains in SETS), ("o", "D", "s", "*"), strict=True))
_LINES: Mapping[str, style.Style] = {
    BASELINE: {"color": "0.4", "linestyle": ":"},
    BOUND: {"color": "black", "linestyle": (0, (4, 3))},
    SMOOTHER: {"color": "black", "linestyle": "-"},
}
# largest factor that has a colour of its own
_MOST = 30.0


def cost_figure(
    medians: xr.DataArray,
    cost: Mapping[str, float],
    lines: xr.DataArray,
    entries: Sequence[Entry],
    shown: Sequence[str],
) -> Figure:
    """RMSE over the time of a step, a panel for each quantity; lines: (line, quantity)."""
    looks = style.observer_styles(list(dict.fromkeys(entry.observer for entry in entries)))
    with settings():
        figure = Figure(figsize=(style.PAGE, 4.6), layout="constrained")
        for axes, quantity in zip(figure.subplots(2, 2, sharex=True).ravel(), shown, strict=True):
            for entry in entries:
                error = float(medians.sel(entry=str(entry), quantity=quantity))
                colour = looks[entry.observer]["color"]
                axes.plot(cost[entry.observer], error, _MARKERS[entry.gains], color=colour, markersize=5)
            for name, look in _LINES.items():
                of = medians.sel(entry=name) if name == BASELINE else lines.sel(line=name)
                axes.axhline(float(of.sel(quantity=quantity)), linewidth=0.8, **look)
            axes.set_yscale("log")
            axes.set_title(signal_of(quantity).symbol, fontsize=9)
        for axes in figure.axes[2:]:
            axes.set_xlabel("ns per step")
        for axes in figure.axes[::2]:
            axes.set_ylabel("RMSE")
        handles = [
            *(
                Line2D([], [], marker="o", linestyle="none", color=look["color"], label=label(name))
                for name, look in looks.items()
            ),
            *(
                Line2D([], [], marker=m, linestyle="none", color="0.3", label=f"{name} gains")
                for name, m in _MARKERS.items()
            ),
            *(Line2D([], [], linewidth=0.8, label=name, **look) for name, look in _LINES.items()),
        ]
        above(figure, handles)
        return figure


def _dot(marker: str, colour: str, words: str) -> Line2D:
    return Line2D([], [], marker=marker, linestyle="none", color=colour, label=words)


def robustness_figure(medians: xr.DataArray) -> Figure:
    """(entry, cell, quantity): geometric mean over quantities of the error over the least one of the cell, as a map."""
    factor = np.exp(np.log(medians.values / np.nanmin(medians.values, axis=0)).mean(axis=2))
    with settings():
        figure = Figure(figsize=(style.PAGE, 0.24 * len(factor) + 1.2), layout="constrained")
        axes = figure.subplots()
        axes.grid(False)
        axes.imshow(factor, norm=LogNorm(1, _MOST), cmap="viridis_r", aspect="auto")
        _numbers(axes, factor)
        axes.set_xticks(range(factor.shape[1]), medians.cell.values, rotation=30, ha="right")
        axes.set_yticks(range(factor.shape[0]), medians.entry.values)
        axes.tick_params(length=0)
        return figure


def _numbers(axes: Axes, values: np.ndarray) -> None:
    for (i, j), value in np.ndenumerate(values):
        words = "–" if np.isnan(value) else f"{value:.2g}"
        axes.text(
            j, i, words, ha="center", va="center", fontsize=7, color="white" if value > np.sqrt(_MOST) else "black"
        )
