"""`hillobs figures` and `hillobs curves`: drawing without a run."""

from __future__ import annotations

from pathlib import Path

import click

from ..estimate.files import SHEET
from ..estimate.schema import check_estimates
from ..figures.estimate import estimate_sheet
from ..figures.muscle_curves import curve_figure
from ..figures.page import write_figures
from ..figures.run import save_figures
from ..figures.sweep.figures import save_sweep_figures
from ..files.datasets.netcdf import load
from ..files.errors import ResultError
from ..files.pictures import PNG, WITH_PDF
from ..files.writing import writable_folder
from ..simulate.schema import check_run
from ..sweep.schema import check_sweep
from .reports.written import written
from .shell.terminal import say

# the variable that only a run has, or a sweep, or estimates
_CHECKS = {"x_hat": check_run, "failed_at": check_sweep, "activation_hat": check_estimates}
_kinds_option = click.option(
    "--pdf", "kinds", is_flag=True, callback=lambda _, __, asked: WITH_PDF if asked else PNG, help="As PDF too."
)


@click.command()
@click.argument("result", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Where figures are written; beside RESULT by default.")
@_kinds_option
def figures(result: Path, out: Path | None, kinds: tuple[str, ...]) -> None:
    """Draw the figures of RESULT.nc, a run, a sweep or estimates, again without a run."""
    dataset = load(result)
    kind = next((name for name in _CHECKS if name in dataset), None)
    if kind is None:
        raise ResultError(f"{result} cannot be drawn: it is no run, no sweep and no estimates")
    try:
        _CHECKS[kind](dataset)
    except ResultError as error:
        raise ResultError(f"{result} cannot be drawn: {error}") from error
    folder = writable_folder(out or result.parent)
    sentence = ""
    if kind == "failed_at":
        paths, sentence = save_sweep_figures(dataset, folder, result.stem, kinds)
    elif kind == "x_hat":
        paths = save_figures(dataset, folder, result.stem, kinds)
    else:
        paths = write_figures({SHEET: estimate_sheet(dataset)}, folder, result.stem, kinds)
    if sentence:
        say(sentence)
    if paths:
        say(written(paths))


@click.command()
@click.option("--out", type=click.Path(path_type=Path), default=Path("results"), help="Where the figure is written.")
@_kinds_option
def curves(out: Path, kinds: tuple[str, ...]) -> None:
    """Draw the muscle's curves of every publication side by side; `list curves` describes them."""
    say(written(write_figures({"sets": curve_figure()}, writable_folder(out), "curves", kinds)))
