"""The figures of a sweep: curves over one parameter, maps over two, points over more."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from ....observers import label
from ...files.pictures import PNG
from ...sweep.optimum import axes_of, depends, shown_of
from ...sweep.pictures import CURVES, MOST_COLUMNS, POINTS, map_of, possible
from ..page import write_figures
from .curves import curves
from .maps import maps
from .scatter import scatter

# what is drawn if all quantities are scored
SHOWN = ("x2", "Delta", "u1", "a1")


def sweep_figures(dataset: xr.Dataset) -> tuple[dict[str, Figure], str]:
    """The figures by name, and a sentence where they are not what is expected: `curves`, `map-OBSERVER` or `points`."""
    axes, observers, quantities = axes_of(dataset), dataset.observer.values.tolist(), shown_of(dataset, SHOWN)
    paths, names = axes.varied, possible(axes, observers)
    if not paths:
        return {}, "no figure: no parameter has more than one value"
    if not names:
        return {}, f"no figure: {len(paths)} parameters vary, more than {MOST_COLUMNS}"
    if names == [CURVES]:
        return {CURVES: curves(dataset, quantities)}, ""
    if names == [POINTS]:
        why = "more than two parameters" if axes.kind == "grid" else "points that are no grid"
        sentence = f"{why}: the figure has a column of points per parameter, no map"
        return {POINTS: scatter(dataset, quantities)}, sentence
    changes = {name: depends(dataset, name) for name in observers}
    still = [label(name) for name, any_change in changes.items() if not any_change]
    drawn = {map_of(name): maps(dataset, name, quantities) for name, any_change in changes.items() if any_change}
    return drawn, f"no map of {', '.join(still)}: {' and '.join(paths)} do not change it" if still else ""


def save_sweep_figures(
    dataset: xr.Dataset, folder: str | Path, stem: str, kinds: Sequence[str] = PNG
) -> tuple[list[Path], str]:
    """Write every figure as `STEM-KEY.KIND`; the paths, and the sentence of `sweep_figures`."""
    drawn, sentence = sweep_figures(dataset)
    return write_figures(drawn, folder, stem, kinds), sentence
