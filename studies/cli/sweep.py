"""`hillobs sweep`: a scenario over parameters and seeds."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import xarray as xr

from ...observers.score import MEASURES
from ..files.errors import ClusterError, ScenarioError
from ..files.numbers import typed_whole
from ..files.quote import escaped, shown
from ..files.writing import refuse_overwriting, writable_folder
from ..scenarios.layers import Value
from ..sweep.axes import DESIGNS, Values
from ..sweep.pictures import sweep_figure_paths
from ..sweep.plan import MANY_RUNS, plan
from ..sweep.run import engine, sweep_planned
from .reports.sweep import notes, step_table, tables
from .shell.options import corrected_option, observer_option, over_option, set_option, whole_option
from .shell.own_observers import loaded
from .shell.pace import Pace
from .shell.progress import bar, counting
from .shell.scenario_arguments import scenario_argument
from .shell.stopping import Stopped
from .shell.tables import print_table
from .shell.terminal import NUMERICAL, say


@click.command()
@scenario_argument("paper-noisy")
@over_option()
@whole_option("--seeds", 1, "Runs per point, with the seeds 0 to N − 1.", default=1)
@click.option("--zip", "zipped", is_flag=True, help="The i-th values go together, instead of all combinations.")
@click.option("--design", metavar="KIND:N", help="N points of a design in the ranges: latin:N or sobol:N.")
@observer_option()
@corrected_option(default=False)
@set_option("Change a number of the scenario.")
@click.option("--out", metavar="FILE.nc", help="Where result and figures go; an unfinished sweep goes on there.")
@click.option("--quantity", "quantities", multiple=True, metavar="NAME", help="Score x2, Delta, … only; repeatable.")
@click.option(
    "--measure", "kinds", multiple=True, metavar="NAME", help="Take peak, settling, chattering only; the RMSE always."
)
@click.option("--no-figures", is_flag=True, help="Write no figures.")
@whole_option("--workers", 1, "Threads, or processes of a local cluster; one per core by default.")
@click.option("--target", metavar="NAME", help="Processors to compile for: this one; for a cluster, a class of them.")
@click.option(
    "--cluster", metavar="ADDRESS|local", help="Run on the dask scheduler at tls://HOST:PORT, or on one made here."
)
@click.option("--yes", is_flag=True, help="Do not ask before a very large sweep.")
def sweep(
    scenario: str,
    over: dict[str, Values],
    seeds: int,
    zipped: bool,
    design: str | None,
    observers: tuple[str, ...],
    corrected: bool,
    changes: dict[str, Value],
    out: str | None,
    quantities: tuple[str, ...],
    kinds: tuple[str, ...],
    no_figures: bool,
    workers: int | None,
    target: str | None,
    cluster: str | None,
    yes: bool,
) -> None:
    """Run SCENARIO for all values of some parameters and many seeds; print where the errors are smallest."""
    with _noting_what_is_kept(out):
        planned = plan(
            scenario,
            over,
            seeds,
            loaded(observers),
            changes,
            *_kind(zipped, design),
            quantities or None,
            kinds or MEASURES,
            corrected,
        )
        if planned.runs > MANY_RUNS and not yes:
            raise ScenarioError(f"{planned.runs:,} runs are more than {MANY_RUNS:,}; say --yes if they are meant")
        path = None if out is None else writable_folder(Path(out).parent) / Path(out).name
        if path is not None and not no_figures:
            refuse_overwriting(sweep_figure_paths(planned.axes, planned.observers, path.parent, path.stem))
        with engine(workers, cluster) as (compute, usual), counting("runs", planned.runs) as advance:
            pace = Pace(advance)
            try:
                dataset = sweep_planned(planned, path, compute, usual if target is None else target, pace)
            except ClusterError as error:
                raise ClusterError("; ".join([str(error), *_kept(out)])) from error
        written = [] if path is None else _written(dataset, path, no_figures)
        say(*pace.sentences(), *notes(dataset))
        for table in (*tables(dataset), *step_table(dataset)):
            print_table(table)
        say(*written)
    if dataset.failed_at.notnull().any() or dataset.plant_failed_at.notnull().any():
        sys.exit(NUMERICAL)


def _kind(zipped: bool, design: str | None) -> tuple[str, int]:
    """How the points are made, and how many a design has."""
    if design is None:
        return ("zip" if zipped else "grid"), 0
    if zipped:
        raise ScenarioError("--zip and --design exclude each other")
    kind, colon, samples = design.partition(":")
    if kind not in DESIGNS or not colon:
        raise ScenarioError(f"--design must be {' or '.join(f'{name}:N' for name in DESIGNS)}, not {shown(design)}")
    return kind, typed_whole("--design", samples, 0)


def _written(dataset: xr.Dataset, path: Path, no_figures: bool) -> list[str]:
    """Draw the figures beside the result, and say where both are."""
    written = f"written to {path}"
    if no_figures:
        return [written]
    from ..figures.sweep.figures import save_sweep_figures  # here, since matplotlib takes as long to come as a run

    with bar("drawing"):
        drawn, sentence = save_sweep_figures(dataset, path.parent, path.stem)
    names = "".join(f", {figure.name}" for figure in drawn)
    return [*filter(None, [sentence]), f"{written}{names}"]


@contextlib.contextmanager
def _noting_what_is_kept(out: str | None) -> Iterator[None]:
    """A signal that ends the sweep is noted where its work is."""
    try:
        yield
    except Stopped as stopped:
        for sentence in _kept(out):
            stopped.add_note(escaped(sentence))
        raise


def _kept(out: str | None) -> list[str]:
    """Where the work of a sweep that was stopped is; nothing if there is none."""
    if out and os.path.isdir(f"{out}.parts"):
        return [f"what is done is kept in {out}.parts, the same command goes on"]
    return [f"the result is in {out}, the same command draws it"] if out and os.path.isfile(out) else []
