"""The figures of a sweep: curves over one parameter, maps over two, points over more."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from ....observers import label
from ...sweep.axes import Axes
from ...sweep.optimum import axes_of, depends, shown_of
from ..page import figure_paths, write_figures
from .curves import curves
from .maps import maps
from .scatter import scatter

# what is drawn if all quantities are scored
SHOWN = ("x2", "Delta", "u1", "a1")
# columns that a page has room for
_MOST_COLUMNS = 5
_CURVES, _POINTS = "curves", "points"


def sweep_figures(dataset: xr.Dataset) -> tuple[dict[str, Figure], str]:
    """The figures by name, and a sentence where they are not what is expected: `curves`, `map-OBSERVER` or `points`."""
    axes, observers, quantities = axes_of(dataset), dataset.observer.values.tolist(), shown_of(dataset, SHOWN)
    paths, possible = axes.varied, _possible(axes, observers)
    if not paths:
        return {}, "no figure: no parameter has more than one value"
    if not possible:
        return {}, f"no figure: {len(paths)} parameters vary, more than {_MOST_COLUMNS}"
    if possible == [_CURVES]:
        return {_CURVES: curves(dataset, quantities)}, ""
    if possible == [_POINTS]:
        why = "more than two parameters" if axes.kind == "grid" else "points that are no grid"
        sentence = f"{why}: the figure has a column of points per parameter, no map"
        return {_POINTS: scatter(dataset, quantities)}, sentence
    changes = {name: depends(dataset, name) for name in observers}
    still = [label(name) for name, any_change in changes.items() if not any_change]
    drawn = {_map_of(name): maps(dataset, name, quantities) for name, any_change in changes.items() if any_change}
    return drawn, f"no map of {', '.join(still)}: {' and '.join(paths)} do not change it" if still else ""


def sweep_figure_paths(axes: Axes, observers: Sequence[str], folder: Path, stem: str) -> list[Path]:
    """The files that `save_sweep_figures` may write of such a sweep."""
    return figure_paths(folder, stem, _possible(axes, observers))


def _possible(axes: Axes, observers: Sequence[str]) -> list[str]:
    """The names of the figures that a sweep may have."""
    varied = len(axes.varied)
    if axes.kind == "grid" and varied == 1:
        return [_CURVES]
    if axes.kind == "grid" and varied == 2:
        return [_map_of(name) for name in observers]
    return [_POINTS] if 0 < varied <= _MOST_COLUMNS else []


def _map_of(observer: str) -> str:
    return f"map-{observer}"


def save_sweep_figures(dataset: xr.Dataset, folder: str | Path, stem: str) -> tuple[list[Path], str]:
    """Write every figure as `STEM-KEY.png` and `.pdf`; the paths, and the sentence of `sweep_figures`."""
    drawn, sentence = sweep_figures(dataset)
    return write_figures(drawn, folder, stem), sentence
