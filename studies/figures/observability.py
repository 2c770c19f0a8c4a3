"""Figures of observability: a map, a run, and why a slack tendon cannot be seen."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from ...model.arrays import Array
from ...model.symbols import SIGNALS
from ..observability.map import TENSION
from ..observability.point import answer
from ..observability.question import SENSORS, Question
from . import style
from .page import settings

# from nothing lost (light) to much lost (dark)
_LOSS = ("#f7f7f7", "#bdd7e7", "#6baed6", "#3182bd", "#08519c", "#08306b", "#041c3f")
_LINE = 1.2


def map_figure(data: xr.Dataset, question: Question) -> Figure:
    """Rank as colour classes beside the conditioning on a logarithmic scale, with slack, toe and linear regions."""
    with settings():
        figure = Figure(figsize=(style.PAGE, 3.1), layout="constrained")
        left, right = figure.subplots(1, 2, sharey=True)
        _rank_panel(figure, left, data)
        _fading_panel(figure, right, data)
        for axes in (left, right):
            _frame(axes, data, question)
        return figure


def along_figure(data: xr.Dataset) -> Figure:
    """Rank and conditioning over the run; slack episodes shaded per muscle."""
    with settings():
        figure = Figure(figsize=(style.PAGE, 3.0), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True)
        time, n = data.time.values, len(data.attrs["estimated"].split(","))
        top.step(time, data["rank"], where="post", color="black", linewidth=_LINE)
        top.set_ylim(0, n + 0.5)
        top.set_yticks(range(0, n + 1, 1 if n < 6 else 2))
        top.set_ylabel(f"rank of {n}")
        seen = data["conditioning"].where(data["conditioning"] > _NOTHING * data["conditioning"].max())
        bottom.set_yscale("log")
        bottom.set_ylim(_decade(seen.min()) / 3, _decade(seen.max()) * 3)
        bottom.plot(time, seen, color="black", linewidth=_LINE, scaley=False)
        bottom.set_xlim(time[0], time[-1])
        bottom.set_ylabel(r"$\sigma_{\min}$")
        bottom.set_xlabel(SIGNALS["t"].symbol)
        for j, shade in ((1, "0.88"), (2, "0.78")):
            slack = data.taut.sel(muscle=j).values == 0
            for axes in (top, bottom):
                axes.fill_between(
                    time, 0, 1, where=slack, transform=axes.get_xaxis_transform(), color=shade, linewidth=0,
                    label=f"tendon {j} slack", step="post", zorder=0,
                )  # fmt: skip
        if (data.taut == 0).any():
            top.legend(loc="lower right", ncols=2)
        return figure


def _decade(value: xr.DataArray) -> float:
    """A limit of a logarithmic axis; 1 where nothing can be seen at all."""
    return float(value) if value.notnull() else 1.0


def explanation(question: Question, point: dict[str, float]) -> Figure:
    """Why a slack tendon cannot be observed: one force for many lengths, and what is left of x₃ as it slackens."""
    with settings():
        figure = Figure(figsize=(style.PAGE, 2.7), layout="constrained")
        left, middle, right = figure.subplots(1, 3)
        slack, end = question.tendon("muscle1").edges
        _force_panel(left, question, slack, end)
        _slope_panel(middle, question, slack, end)
        _deviation_panel(right, question, point, slack, end)
        for axes in (left, middle):
            axes.axvline(slack, color="0.5", linewidth=0.8, linestyle=":")
            axes.set_xlabel(SIGNALS["x3"].symbol)
        right.set_xlabel(f"{SIGNALS['x3'].symbol} $-$ {slack:g}")
        return figure


def _rank_panel(figure: Figure, axes: Axes, data: xr.Dataset) -> None:
    n = len(data.attrs["estimated"].split(","))
    ranks = sorted({int(rank) for rank in np.unique(data["rank"]) if rank >= 0}, reverse=True)
    colours = ListedColormap([_LOSS[min(n - rank, len(_LOSS) - 1)] for rank in ranks[::-1]])
    edges = [*(rank - 0.5 for rank in ranks[::-1]), ranks[0] + 0.5]
    shown = np.where(data["rank"] >= 0, data["rank"].astype(float), np.nan)
    x, y = (data[name].values for name in data["rank"].dims)
    mesh = axes.pcolormesh(x, y, shown.T, cmap=colours, norm=BoundaryNorm(edges, colours.N), rasterized=True)
    bar = figure.colorbar(mesh, ax=axes, ticks=ranks[::-1])
    bar.set_label(f"rank of {n}")


def _fading_panel(figure: Figure, axes: Axes, data: xr.Dataset) -> None:
    """The determinant if there is one, else the conditioning, on a logarithmic scale; grey where it is 0."""
    name = "determinant" if "determinant" in data else "conditioning"
    label = r"$\log_{10}\,|\det|$" if name == "determinant" else r"$\log_{10}\,\sigma_{\min}$"
    x, y = (data[axis].values for axis in data[name].dims)
    values = data[name].values
    shown = np.log10(values, out=np.full(values.shape, np.nan), where=values > _NOTHING * np.nanmax(values))
    axes.set_facecolor("0.6")
    mesh = axes.pcolormesh(x, y, shown.T, cmap="viridis", rasterized=True)
    figure.colorbar(mesh, ax=axes).set_label(f"{label}; grey: 0")


# part of the largest value that is 0 in double precision
_NOTHING = 1e-12


def _frame(axes: Axes, data: xr.Dataset, question: Question) -> None:
    """Axis labels, and the edges of slack and toe where an axis is a tendon's."""
    axes.grid(visible=False)
    first, second = data["rank"].dims
    for name, label, line in ((first, axes.set_xlabel, axes.axvline), (second, axes.set_ylabel, axes.axhline)):
        label("common tension" if name == TENSION else SIGNALS[str(name)].symbol)
        if name == TENSION:
            line(0, color="white", linewidth=1.6)
            line(0, color="black", linewidth=0.8)
            label("common tension (below 0: slack)")
        if name in ("x3", "x4"):
            slack, end = question.tendon(f"muscle{int(str(name)[1]) - 2}").edges
            line(slack, color="white", linewidth=1.6)
            line(slack, color="black", linewidth=0.8)
            line(end, color="black", linewidth=0.8, linestyle="--")
            _region_names(axes, str(name) == first, data[name].values, slack, end)


def _region_names(axes: Axes, horizontal: bool, values: Array, slack: float, end: float) -> None:
    places = {"slack": (values[0] + slack) / 2, "toe": (slack + end) / 2, "linear": (end + values[-1]) / 2}
    for name, place in places.items():
        if horizontal:
            axes.text(place, 1.01, name, transform=axes.get_xaxis_transform(), ha="center", va="bottom")
        else:
            axes.text(1.01, place, name, transform=axes.get_yaxis_transform(), rotation=90, ha="left", va="center")


def _force_panel(axes: Axes, question: Question, slack: float, end: float) -> None:
    """A reading fits an interval of lengths; below the noise the interval has no end."""
    toe, noise = end - slack, SENSORS["F1"].noise
    lengths = np.linspace(slack - toe / 2, slack + 0.7 * toe, 20001)
    force = question.tendon("muscle1").force(lengths)
    axes.plot(lengths[::20], force[::20], color="black", linewidth=_LINE)
    for reading, colour in ((float(np.interp(slack + toe / 2, lengths, force)), "#0072B2"), (noise, "#D55E00")):
        fits = lengths[np.abs(force - reading) <= noise]
        low, high = fits[0], fits[-1]
        middle, half = (low + high) / 2, (high - low) / 2
        words = f"{middle:.4f} ± {half:.4f}" if low > lengths[0] else f"below {high:.4f}"
        axes.axvspan(low, high, color=colour, alpha=0.2, linewidth=0)
        axes.axhline(reading, color=colour, linewidth=0.8, label=f"{reading:.3f} → {words}")
    # left of the curve, which rises at the right
    axes.legend(loc="upper left", handlelength=1.2, frameon=True, framealpha=1, edgecolor="none", borderpad=0.2)
    axes.set_xlim(lengths[0], lengths[-1])
    axes.set_ylabel(SIGNALS["y2"].symbol)
    axes.set_title(rf"lengths that fit a force $\pm$ {noise:g}", fontsize="medium")


def _slope_panel(axes: Axes, question: Question, slack: float, end: float) -> None:
    """What is left of the measured change, and of the determinant of the whole map."""
    lengths = np.linspace(slack - 0.2 * (end - slack), end, 600)
    slope = question.tendon("muscle1").slope(lengths)
    axes.plot(lengths, slope / slope[-1], color="black", linewidth=_LINE, label=r"$\Phi'_{S1}$")
    axes.plot(lengths, (slope / slope[-1]) ** 2, color="#009E73", linewidth=_LINE, linestyle="--", label=r"$|\det|$")
    axes.set_xlim(lengths[0], lengths[-1])
    axes.legend(loc="upper left")
    axes.set_title("what of a change reaches the sensor", fontsize="medium")


def _deviation_panel(axes: Axes, question: Question, point: dict[str, float], slack: float, end: float) -> None:
    """The smallest standard deviation of x₃ from samples of a moment."""
    depth = np.geomspace(2e-4, 1, 25) * (end - slack)
    for name, colour, line in (("x3", "black", "-"), ("x4", "0.5", "--")):
        spread = [answer(question, {**point, "x3": slack + d}, window=_MOMENT).deviations[name] for d in depth]
        axes.loglog(depth, spread, color=colour, linestyle=line, linewidth=_LINE, label=SIGNALS[name].symbol)
    axes.legend(loc="upper right")
    axes.set_title(rf"smallest $\sigma$ from {_MOMENT:g} time units", fontsize="medium")


# long enough for a few samples, too short for the tendon to move
_MOMENT = 0.02
