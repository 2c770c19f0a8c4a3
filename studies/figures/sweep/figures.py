"""The figures of a sweep: curves over one parameter, maps over two, points over more."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from ...sweep.optimum import shown_of
from ..page import write_figures
from .curves import curves
from .maps import maps
from .panels import varied
from .scatter import scatter

_SHOWN = ("x2", "Delta", "u1", "a1")
# columns that a page has room for
_MOST_COLUMNS = 5


def sweep_figures(dataset: xr.Dataset) -> tuple[dict[str, Figure], str]:
    """The figures by name, and a sentence where they are not what is expected: `curves`, `map-OBSERVER` or `points`."""
    paths, grid, quantities = varied(dataset), dataset.attrs["kind"] == "grid", shown_of(dataset, _SHOWN)
    if not paths:
        return {}, "no figure: no parameter has more than one value"
    if grid and len(paths) == 1:
        return {"curves": curves(dataset, quantities)}, ""
    if grid and len(paths) == 2:
        return {f"map-{name}": maps(dataset, name, quantities) for name in dataset.observer.values.tolist()}, ""
    if len(paths) > _MOST_COLUMNS:
        return {}, f"no figure: {len(paths)} parameters vary, more than {_MOST_COLUMNS}"
    why = "more than two parameters" if grid else "points that are no grid"
    return {"points": scatter(dataset, quantities)}, f"{why}: the figure has a column of points per parameter, no map"


def save_sweep_figures(dataset: xr.Dataset, folder: str | Path, stem: str) -> tuple[list[Path], str]:
    """Write every figure as `STEM-KEY.png` and `.pdf`; the paths, and the sentence of `sweep_figures`."""
    drawn, sentence = sweep_figures(dataset)
    return write_figures(drawn, folder, stem), sentence
