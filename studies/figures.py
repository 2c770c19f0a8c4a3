"""The paper's data figures, drawn from the Dataset of a run."""

from __future__ import annotations

import io
import json
import os
import secrets
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import casadi as ca
import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..codegen.library import Array
from ..model.block import Symbols
from ..model.curves import CURVES, CurveSet
from ..model.symbols import MUSCLES, SIGNALS, STATES, hat
from . import style
from .transient import series, slack, start

# the part after the start gets its own scale if the start makes the range this many times larger
_HIDES = 1.8
# more than a printed line can show
_MOST_POINTS = 6000
_ROW = 1.25  # inches


def figures(dataset: xr.Dataset) -> dict[str, Figure]:
    """All figures of one run: `phi_s`, `reference`, `states`, `inputs`, `activations`."""
    with _settings():
        return {
            "phi_s": phi_s(dataset),
            "reference": reference(dataset),
            "states": estimates(dataset, STATES),
            "inputs": estimates(dataset, ("Delta", "u1", "u2")),
            "activations": estimates(dataset, ("a1", "a2")),
        }


def save_figures(dataset: xr.Dataset, folder: str | Path, stem: str) -> list[Path]:
    """Write every figure as `STEM-KEY.png` and `.pdf`; the same run gives the same bytes."""
    paths = []
    for key, figure in figures(dataset).items():
        for kind, undated in (("png", {"Software": None}), ("pdf", {"CreationDate": None})):
            content = io.BytesIO()
            with _settings():
                figure.savefig(content, format=kind, metadata=undated)
            paths.append(Path(folder) / f"{stem}-{key}.{kind}")
            _write(paths[-1], content.getvalue())
    return paths


def phi_s(dataset: xr.Dataset) -> Figure:
    """Φ_S over the tendon length, its regions marked; a panel per muscle if their tendons differ."""
    curves = CURVES[json.loads(dataset.attrs["choices"])["muscle.curves"]]
    parameters = json.loads(dataset.attrs["parameters"])
    tendons = {muscle: {key: float(parameters[f"{muscle}.{key}"]) for key in curves.tendon} for muscle in MUSCLES}
    if tendons[MUSCLES[0]] == tendons[MUSCLES[1]]:
        tendons = {"": tendons[MUSCLES[0]]}
    figure = Figure(figsize=(style.COLUMN * len(tendons), 2.5), layout="constrained")
    for axes, (muscle, tendon) in zip(figure.subplots(1, len(tendons), squeeze=False).flat, tendons.items(), strict=True):
        _tendon_curve(axes, curves, tendon, muscle[-1:] or "j")
    return figure


def reference(dataset: xr.Dataset) -> Figure:
    """The reference, if there is one, the measured position and the true one."""
    figure = Figure(figsize=(style.COLUMN, 2.3), layout="constrained")
    axes, time = figure.subplots(), _time(dataset)
    position, measured = series(dataset, "x1"), dataset["y"].sel(sensor="y1")
    symbol = {name: SIGNALS[name].symbol for name in ("r", "x1", "y1")}
    if "r" in dataset:
        _line(axes, time, dataset["r"], style.REFERENCE, symbol["r"])
    if np.array_equal(position, measured, equal_nan=True):
        _line(axes, time, position, style.TRUE, f"{symbol['y1']} = {symbol['x1']}")
    else:
        _line(axes, time, measured, style.MEASURED, symbol["y1"])
        _line(axes, time, position, style.TRUE, symbol["x1"])
    _time_axis(axes, 0, time[-1])
    axes.set_ylabel(", ".join(symbol[name] for name in ("r", "y1") if name in dataset or name == "y1"))
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def estimates(dataset: xr.Dataset, quantities: Sequence[str]) -> Figure:
    """True value and estimates, a row per quantity; the start has a column of its own where it hides the rest."""
    time, end = _time(dataset), start(dataset)
    rest = {quantity: _limits(dataset, quantity, time >= end) for quantity in quantities}
    whole = {quantity: _limits(dataset, quantity, time >= 0) for quantity in quantities}
    hidden = [q for q in quantities if np.ptp(whole[q]) > _HIDES * np.ptp(rest[q])]
    spans = [(0.0, end), (end, time[-1])] if hidden else [(0.0, time[-1])]
    figure = Figure(figsize=(style.PAGE, 0.7 + _ROW * len(quantities)), layout="constrained")
    grid = figure.subplots(
        len(quantities), len(spans), sharex="col", squeeze=False, width_ratios=[1, 2] if hidden else [1]
    )
    for quantity, row in zip(quantities, grid, strict=True):
        for axes, span in zip(row, spans, strict=True):
            _draw(axes, dataset, quantity)
            axes.set_ylim(whole[quantity])
            _time_axis(axes, *span)
        if quantity in hidden:
            row[-1].set_ylim(rest[quantity])
        row[0].set_ylabel(SIGNALS[quantity].symbol)
    for axes in grid.flat:
        axes.label_outer(remove_inner_ticks=False) if False else None
    figure.align_ylabels(grid[:, 0])
    _legend(figure, dataset, grid[0, 0], any(slack(dataset, quantity).any() for quantity in quantities))
    return figure
