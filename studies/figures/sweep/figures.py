"""The figures of a sweep: curves over one parameter, maps over two, points over more."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from ....observers import label
from ...sweep.optimum import depends, shown_of, varied
from ..page import write_figures
from .curves import curves
from .maps import maps
from .scatter import scatter

# what is drawn if all quantities are scored
SHOWN = ("x2", "Delta", "u1", "a1")
# columns that a page has room for
_MOST_COLUMNS = 5


def sweep_figures(dataset: xr.Dataset) -> tuple[dict[str, Figure], str]:
    """The figures by name, and a sentence where they are not what is expected: `curves`, `map-OBSERVER` or `points`."""
    paths, grid, quantities = varied(dataset), dataset.attrs["kind"] == "grid", shown_of(dataset, SHOWN)
    if not paths:
        return {}, "no figure: no parameter has more than one value"
    if grid and len(paths) == 1:
        return {"curves": curves(dataset, quantities)}, ""
    if grid and len(paths) == 2:
        changes = {name: depends(dataset, name) for name in dataset.observer.values.tolist()}
        still = [label(name) for name, any_change in changes.items() if not any_change]
        drawn = {f"map-{name}": maps(dataset, name, quantities) for name, any_change in changes.items() if any_change}
        return drawn, f"no map of {', '.join(still)}: {' and '.join(paths)} do not change it" if still else ""
    if len(paths) > _MOST_COLUMNS:
        return {}, f"no figure: {len(paths)} parameters vary, more than {_MOST_COLUMNS}"
    why = "more than two parameters" if grid else "points that are no grid"
    return {"points": scatter(dataset, quantities)}, f"{why}: the figure has a column of points per parameter, no map"


def save_sweep_figures(dataset: xr.Dataset, folder: str | Path, stem: str) -> tuple[list[Path], str]:
    """Write every figure as `STEM-KEY.png` and `.pdf`; the paths, and the sentence of `sweep_figures`."""
    drawn, sentence = sweep_figures(dataset)
    return write_figures(drawn, folder, stem), sentence
