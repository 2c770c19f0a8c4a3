"""The paper's data figures, drawn from the Dataset of a run."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from ...model.arrays import Array
from ...model.curves.tendon import Tendon, tendon
from ...model.symbols import MUSCLES, SIGNALS, hat, kind_of, signal_of
from ...observers import label
from ..files.pictures import PNG
from ..files.quote import drawn
from ..simulate.files import FIGURES
from ..simulate.schema import curves_by_muscle
from ..simulate.series import series
from . import style
from .page import above, settings, write_figures
from .traces import line, traces
from .views import Flags, infeasible, limits, slack, start, true

# what the last three show
_KINDS = (("q", "dq", "L_S"), ("Delta", "u"), ("a",))

# inches: of a row, of all rows of a page, and the least of a row
_ROW, _PAGE, _LEAST = 1.25, 12.0, 0.8
# panels of tendons side by side
_PANELS = 3
# size of a title, and its letters in an inch
_TITLE, _LETTERS = 8, 15
# along the height of a row
_NUMBERS = 5


def figures(dataset: xr.Dataset) -> dict[str, Figure]:
    """All figures of one run, by the names in FIGURES."""
    with settings():
        of_kind = [[name for name in dataset.quantity.values.tolist() if kind_of(name) in kinds] for kinds in _KINDS]
        groups = (estimates(dataset, quantities) for quantities in of_kind)
        drawn = dict(zip(FIGURES, (phi_s(dataset), reference(dataset), *groups), strict=True))
        for figure in drawn.values():
            _name_changes(figure, dataset)
        return drawn


def _name_changes(figure: Figure, dataset: xr.Dataset) -> None:
    """Above the figure of a run that is not the scenario as it stands: what was changed."""
    scenario, run = dataset.attrs["scenario"], dataset.attrs.get("run", "")
    if changes := run.removeprefix(scenario).strip(","):
        words = f"{scenario}: {changes.replace(',', ', ').replace('=', ' = ')}"
        words = textwrap.fill(drawn(words), int(_LETTERS * figure.get_figwidth()))
        # above the panels a title would lie on the legend
        if figure.legends:
            figure.legends[0].set_title(words, FontProperties(size=_TITLE))
        else:
            figure.suptitle(words, fontsize=_TITLE)


def save_figures(dataset: xr.Dataset, folder: str | Path, stem: str, kinds: Sequence[str] = PNG) -> list[Path]:
    """Write every figure as `STEM-KEY.KIND`; the same run gives the same bytes."""
    return write_figures(figures(dataset), folder, stem, kinds)


def phi_s(dataset: xr.Dataset) -> Figure:
    """Φ_S over the tendon length, its regions marked; a panel per muscle if their tendons differ."""
    parameters = json.loads(dataset.attrs["parameters"])
    tendons = {muscle: tendon(curves, muscle, parameters) for muscle, curves in curves_by_muscle(dataset).items()}
    first = next(iter(tendons.values()))
    if all(other == first for other in tendons.values()):
        tendons = {"": first}
    rows = -(-len(tendons) // _PANELS)
    columns = -(-len(tendons) // rows)
    figure = Figure(figsize=(style.COLUMN * columns, 2.5 * rows), layout="constrained")
    panels = list(figure.subplots(rows, columns, squeeze=False).flat)
    for spare in panels[len(tendons) :]:
        spare.remove()
    for axes, (muscle, shown) in zip(panels, tendons.items(), strict=False):
        _tendon_curve(axes, shown, muscle[-1] if muscle in MUSCLES else f",{muscle}" if muscle else "j")
    return figure


def reference(dataset: xr.Dataset) -> Figure:
    """The reference, if there is one, the measured position and the true one; of a mechanism all that is led."""
    return _led(dataset) if "joint" in dataset else _position(dataset)


def _led(dataset: xr.Dataset) -> Figure:
    """What follows a reference, a row each, and of a point's first two coordinates the path; else all joints."""
    time, places = _time(dataset), dataset.place.values.tolist() if "place" in dataset else []
    shown = places or dataset.joint.values.tolist()
    path = [name for name in places if "." in name][:2]
    columns = 2 if len(path) > 1 else 1
    figure = Figure(figsize=(style.PAGE if columns > 1 else style.COLUMN, 0.7 + 1.6 * len(shown)), layout="constrained")
    grid = figure.add_gridspec(len(shown), columns)
    for row, name in enumerate(shown):
        axes = figure.add_subplot(grid[row, 0])
        if places:
            line(axes, time, dataset["r"].sel(place=name), style.REFERENCE, "reference")
            line(axes, time, dataset["at"].sel(place=name), style.TRUE, "true")
        else:
            line(axes, time, dataset["y"].sel(sensor=f"{name}.y"), style.MEASURED, "measured")
            line(axes, time, dataset["x"].sel(state=f"{name}.q"), style.TRUE, "true")
        _set_time(axes, 0, time[-1])
        axes.set_ylabel(drawn(name))
    axes.set_xlabel(SIGNALS["t"].symbol)
    if len(path) > 1:
        across = figure.add_subplot(grid[:, 1])
        for variable, look in (("r", style.REFERENCE), ("at", style.TRUE)):
            across.plot(*(dataset[variable].sel(place=name).values for name in path), **look)
        across.set_aspect("equal", "datalim")
        across.set_xlabel(drawn(path[0]))
        across.set_ylabel(drawn(path[1]))
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure


def _position(dataset: xr.Dataset) -> Figure:
    """The same of the pair."""
    figure = Figure(figsize=(style.COLUMN, 2.3), layout="constrained")
    axes, time = figure.subplots(), _time(dataset)
    position, measured = series(dataset, "x1"), dataset["y"].sel(sensor="y1")
    symbol = {name: SIGNALS[name].symbol for name in ("r", "x1", "y1")}
    if "r" in dataset:
        line(axes, time, dataset["r"], style.REFERENCE, symbol["r"])
    if np.array_equal(position, measured, equal_nan=True):
        line(axes, time, position, style.TRUE, f"{symbol['y1']} = {symbol['x1']}")
    else:
        line(axes, time, measured, style.MEASURED, symbol["y1"])
        line(axes, time, position, style.TRUE, symbol["x1"])
    _set_time(axes, 0, time[-1])
    axes.set_xlabel(SIGNALS["t"].symbol)
    axes.set_ylabel(symbol["y1"] if "r" not in dataset else f"{symbol['r']}, {symbol['y1']}")
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def estimates(dataset: xr.Dataset, quantities: Sequence[str]) -> Figure:
    """True values and estimates, a row per quantity; where the start hides the rest it gets a column of its own."""
    time, end = _time(dataset), start(dataset)
    scales = {quantity: limits(dataset, quantity, end) for quantity in quantities}
    split = any(len(scale) > 1 for scale in scales.values())
    spans = [(0.0, end), (end, time[-1])] if split else [(0.0, time[-1])]
    height = min(_ROW * len(quantities), max(_PAGE, _LEAST * len(quantities)))
    figure = Figure(figsize=(style.PAGE, 0.7 + height), layout="constrained")
    rows = figure.subplots(len(quantities), len(spans), sharex="col", squeeze=False, width_ratios=[1, 2][-len(spans) :])
    bands = False
    for quantity, row in zip(quantities, rows, strict=True):
        for axes, span, scale in zip(row, spans, scales[quantity] * len(spans), strict=False):
            axes.set_ylim(scale)
            # as many whatever the height: else the layout and the width of the numbers chase each other
            axes.yaxis.set_major_locator(MaxNLocator(_NUMBERS, steps=[1, 2, 2.5, 5, 10]))
            _set_time(axes, *span)
            bands |= _panel(axes, dataset, quantity)
        row[0].set_ylabel(signal_of(quantity).symbol, rotation=0, ha="right", va="center")
    for axes in rows[-1]:
        axes.set_xlabel(SIGNALS["t"].symbol)
    above(figure, _handles(dataset, quantities, bands))
    return figure


def _panel(axes: Axes, dataset: xr.Dataset, quantity: str) -> bool:
    """One quantity within the limits of the axes, with marks where it means nothing; whether there are bands."""
    time = _time(dataset)
    for flags, look in ((slack(dataset, quantity), style.SLACK), (infeasible(dataset, quantity), style.INFEASIBLE)):
        for first, after in _episodes(flags):
            axes.axvspan(time[first], time[min(after, len(time) - 1)], **look)
    line(axes, time, true(dataset, quantity), style.TRUE, "true")
    names = dataset["observer"].values.tolist()
    estimates = {name: np.asarray(series(dataset, hat(quantity)).sel(observer=name)) for name in names}
    return traces(axes, time, estimates, style.observer_styles(names))


def _name(dataset: xr.Dataset, observer: str) -> str:
    """The observer in the legend, with the time at which it failed."""
    lost = np.asarray(~np.isfinite(dataset["x_hat"].sel(observer=observer))).any(axis=1)
    name = label(observer)
    return rf"{name} (fails at $\tau$ = {_time(dataset)[np.argmax(lost)]:g})" if lost.any() else name


def _handles(dataset: xr.Dataset, quantities: Sequence[str], bands: bool) -> list[Artist]:
    """What the legend above all panels explains."""
    looks = style.observer_styles(dataset["observer"].values.tolist())
    handles: list[Artist] = [Line2D([], [], label="true", **style.TRUE)]
    handles += [Line2D([], [], label=_name(dataset, name), **look) for name, look in looks.items()]
    if bands:
        handles.append(Patch(**style.BAND))
    if any(slack(dataset, quantity).any() for quantity in quantities):
        handles.append(Patch(label="tendon slack", **style.SLACK))
    asked = [series(dataset, quantity).values[infeasible(dataset, quantity)] for quantity in quantities]
    if most := float(np.concatenate(asked).max(initial=0.0)):
        handles.append(Patch(label=f"infeasible: needs $a$ up to {most:.2g}", **style.INFEASIBLE))
    return handles


def _episodes(flags: Flags) -> list[tuple[int, int]]:
    """Where each run of True begins, and where the next False is."""
    edges = np.flatnonzero(np.diff(flags.astype(int), prepend=0, append=0))
    return [(int(first), int(after)) for first, after in edges.reshape(-1, 2)]


def _set_time(axes: Axes, begin: float, end: float) -> None:
    if end > begin:
        axes.set_xlim(begin, end)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=6, steps=[1, 2, 5, 10]))


def _time(dataset: xr.Dataset) -> Array:
    return np.asarray(dataset["time"])


def _tendon_curve(axes: Axes, tendon: Tendon, j: str) -> None:
    """Φ_S of one tendon between half a toe below slack and as far into the linear region."""
    begin, end = tendon.edges
    edges = (begin - (end - begin) / 2, begin, end, end + (end - begin) / 2)
    lengths = np.linspace(edges[0], edges[-1], 801)
    axes.plot(lengths, tendon.force(lengths), color="black", linewidth=1.2)
    regions = (("slack", "0.88"), ("toe", "0.94"), ("linear", "1"))
    for (name, shade), low, high in zip(regions, edges[:-1], edges[1:], strict=True):
        axes.axvspan(low, high, facecolor=shade, zorder=0)
        axes.text((low + high) / 2, 0.95, name, transform=axes.get_xaxis_transform(), ha="center", va="top")
    axes.set_xlim(edges[0], edges[-1])
    axes.set_xlabel(rf"$L_{{S{j}}}$")
    axes.set_ylabel(rf"$\Phi_{{S{j}}}$")
