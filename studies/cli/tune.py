"""`hillobs tune`: gains of an observer by search."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

import click

from ..files.errors import ScenarioError
from ..files.pictures import figure_paths
from ..files.quote import escaped
from ..files.writing import refuse_overwriting, writable_folder, write_whole
from ..scenarios.layers import Value
from ..sweep.axes import Values
from ..sweep.run import engine
from ..tune.run import tuned
from ..tune.task import task
from .reports.tune import factors_table, scenario_file, sentences
from .reports.written import written
from .shell.options import corrected_option, over_option, set_option, whole_option
from .shell.own_observers import loaded
from .shell.progress import bar, counting
from .shell.scenario_arguments import scenario_argument
from .shell.stopping import Stopped
from .shell.tables import print_table
from .shell.terminal import say

_SEARCH = "search"


@click.command()
@scenario_argument("paper-noisy")
@click.option(
    "--observer", "observers", multiple=True, metavar="NAME|FILE.py:NAME", help="Whose gains; also a Block of your own."
)
@click.option(
    "--quantity", "quantities", multiple=True, metavar="NAMES",
    help="An objective: the error of x2, or of x2,Delta,u1 together. Several make a front; one of all by default.",
)  # fmt: skip
@over_option("A number that is tuned: PATH=lin:LOW:HIGH or PATH=log:LOW:HIGH.")
@whole_option("--trials", 1, "How many, in rounds of 50.", default=2000)
@whole_option("--seeds", 1, "Draws of the noise of each training run.", default=4)
@corrected_option(default=False)
@set_option("Change a number of the scenario.")
@click.option(
    "--out", default="results", show_default=True, metavar="DIR", help="Where scenario, figure and trials go."
)
@click.option("--no-figures", is_flag=True, help="Write no figure.")
@whole_option("--workers", 1, "Threads; one per core by default.")
def tune(
    scenario: str,
    observers: tuple[str, ...],
    quantities: tuple[str, ...],
    over: dict[str, Values],
    trials: int,
    seeds: int,
    corrected: bool,
    changes: dict[str, Value],
    out: str,
    no_figures: bool,
    workers: int | None,
) -> None:
    """Find gains of an observer for which its errors in SCENARIO are smallest, within its gain conditions.

    By trials on some runs; the table is of other ones, with other noise and other trajectories. The gains are written
    as a scenario that can be run. A search that was stopped goes on with the same command; with more --trials further.
    """
    folder = writable_folder(Path(out))
    if len(observers) != 1:
        raise ScenarioError(
            f"a search is of one observer: name it with --observer, once and not {len(observers)} times"
        )
    (whose,) = loaded(observers) or observers
    with engine(workers, None) as (compute, _):
        with bar("preparing"):
            asked = task(scenario, whose, quantities or None, over, trials, seeds, changes, corrected, compute)
        stem = f"tuned-{asked.plan.prepared.label}"
        journal, gains = folder / f"{stem}.trials", folder / f"{stem}.toml"
        drawn = [] if no_figures else figure_paths(folder, stem, [_SEARCH])
        refuse_overwriting([gains, *drawn])
        with _noting_what_is_kept(journal), counting("trials", trials) as advance:
            found = tuned(asked, journal, advance)
    say(*sentences(found))
    print_table(factors_table(found))
    write_whole(gains, scenario_file(found).encode())
    if not no_figures:
        from ..figures.page import write_figures  # here, since matplotlib takes as long to come as a run
        from ..figures.tune import search_figure

        with bar("drawing"):
            write_figures({_SEARCH: search_figure(found.trials, found.tests)}, folder, stem)
    say(written([gains, journal, *drawn]))


@contextlib.contextmanager
def _noting_what_is_kept(journal: Path) -> Iterator[None]:
    """A signal that ends the search is noted where its trials are."""
    try:
        yield
    except Stopped as stopped:
        if os.path.isfile(journal):
            stopped.add_note(escaped(f"the trials so far are in {journal}, the same command goes on"))
        raise
