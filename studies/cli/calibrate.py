"""`hillobs calibrate`: the numbers of muscles from trials in which activations were known."""

from __future__ import annotations

import click

from ..calibrate.run import calibrate as calibrated
from ..files.writing import write_whole
from .reports.calibrate import notes, number_table, trial_table
from .reports.written import written
from .shell.options import complete_files
from .shell.places import toml_place
from .shell.progress import bar
from .shell.subjects import subject_asked_for, subject_options
from .shell.tables import print_table
from .shell.terminal import say


@click.command()
@click.argument("trials", nargs=-1, required=True, metavar="TRIAL.toml...", shell_complete=complete_files)
@subject_options()
@click.option(
    "--out",
    default="calibrated.toml",
    show_default=True,
    metavar="FILE.toml",
    shell_complete=complete_files,
    help="Where the muscles with these numbers are written.",
)
def calibrate(trials: tuple[str, ...], muscles: str | None, mechanism: str | None, out: str) -> None:
    """Find optimal fibre length, slack length, F_max and more from recordings with known activation, each a TRIAL.toml.

    What is known before is the muscle file's. The file that is written has the numbers with their standard deviations;
    `hillobs estimate` takes both.
    """
    place, subject = toml_place(out), subject_asked_for(muscles, mechanism)
    with bar("smoothing") as progress:
        found = calibrated(trials, subject, progress)
    print_table(number_table(found))
    print_table(trial_table(found))
    say(*notes(found))
    write_whole(place, found.toml.encode())
    say(written([place]))
