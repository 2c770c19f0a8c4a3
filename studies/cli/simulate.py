"""`hillobs simulate`: one run of each scenario."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import click
import xarray as xr

from ..files.pictures import figure_paths
from ..files.writing import refuse_overwriting, writable_folder
from ..scenarios.layers import Value
from ..scenarios.prepare import prepare
from ..scenarios.scenario import parse_change
from ..simulate.files import FIGURES, run_paths, save
from ..simulate.run import RunWarning, simulate_prepared
from .reports.simulate import failures, notes, tables
from .reports.written import written
from .shell.options import corrected_option, observer_option, set_option
from .shell.own_observers import loaded
from .shell.progress import bar
from .shell.scenario_arguments import scenarios_argument
from .shell.tables import print_table
from .shell.terminal import NUMERICAL, complain, say

_PAPER = ("paper-clean", "paper-noisy")


@click.command()
@scenarios_argument()
@observer_option()
@corrected_option(default=False)
@set_option("Change a number, e.g. plant.m=1.2.")
@click.option("--seed", metavar="N", help="Seed of the measurement noise.")
@click.option("--step", metavar="H", help="Integration step.")
@click.option("--out", default="results", show_default=True, metavar="DIR", help="Where results are written.")
@click.option("--no-figures", is_flag=True, help="Write no figures.")
def simulate(
    scenarios: tuple[str, ...],
    observers: tuple[str, ...],
    corrected: bool,
    changes: dict[str, Value],
    seed: str | None,
    step: str | None,
    out: str,
    no_figures: bool,
) -> None:
    """Simulate scenarios (the paper's two by default), print their measures, write results and figures."""
    for path, typed in (("seed", seed), ("step", step)):
        if typed is not None:
            changes |= dict([parse_change(f"{path}={typed}")])
    chosen = loaded(observers)
    runs = [prepare(name, chosen, changes, corrected=corrected) for name in scenarios or _PAPER]
    folder = writable_folder(Path(out))
    drawn = () if no_figures else FIGURES
    refuse_overwriting(
        path
        for prepared in runs
        for path in (
            *run_paths(folder, prepared.label, not prepared.system.paper),
            *figure_paths(folder, prepared.label, drawn),
        )
    )
    failed = False
    for prepared in runs:
        name = prepared.label
        with bar(f"{name}: simulating") as advance, warnings.catch_warnings():
            warnings.simplefilter("ignore", RunWarning)  # its reason is printed below
            dataset = simulate_prepared(prepared, advance)
        paths = save(dataset, folder)
        if not no_figures:
            from ..figures.run import save_figures  # here, since matplotlib takes as long to come as a run

            with bar(f"{name}: drawing"):
                paths += save_figures(dataset, folder, name)
        _print_report(dataset)
        say(written(paths), "")
        for sentence in failures(dataset):
            complain(sentence)
            failed = True
    if failed:
        sys.exit(NUMERICAL)


def _print_report(dataset: xr.Dataset) -> None:
    about = dataset.attrs
    say(f"{about['scenario']}, seed {about['seed']}: {about['description']}", "")
    for title, table in tables(dataset):
        say(title)
        print_table(table)
    say(*notes(dataset))
