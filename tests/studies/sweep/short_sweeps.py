"""Short sweeps, and how their errors, causes, tables and figures are read."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from hillobs.studies.figures.sweep.figures import sweep_figures

SHORT = {"duration": 0.2, "score.start": 0.05}
# the first two are too small for the step
EPS = [5e-5, 2e-4, 2e-2, 0.1, 0.5]

# what the step asks of the layers of the tendons
LAYER = "h α/δ_L < 2.5 (integration)"


def cause(variable: xr.DataArray) -> str:
    return variable.attrs["flag_meanings"].split()[int(variable)]


def replaced(dataset: xr.Dataset, rmse: object, lost: object) -> xr.Dataset:
    """The Dataset with these errors of every quantity, and these runs lost (…, seed, observer)."""
    result = dataset.copy(deep=True)
    result.rmse[:] = np.asarray(rmse)[..., None]
    result.failed_at[:] = np.where(lost, 0.1, np.nan)
    result.rmse[:] = result.rmse.where(result.failed_at.isnull())
    return result


def drawn(dataset: xr.Dataset, *quantities: str) -> tuple[dict[str, Figure], str]:
    """The figures of some quantities, drawn to the last tick but not written; warnings are errors here."""
    figures, sentence = sweep_figures(dataset.sel(quantity=list(quantities)) if quantities else dataset)
    for figure in figures.values():
        figure.draw_without_rendering()
    return figures, sentence


def legend(figure: Figure) -> list[str]:
    (only,) = figure.legends
    return [text.get_text() for text in only.get_texts()]


def printed(table: Table) -> list[str]:
    """The lines of a table on a terminal that is wide enough."""
    console = Console(width=200)
    with console.capture() as text:
        console.print(table)
    return [line.rstrip() for line in text.get().splitlines()]
