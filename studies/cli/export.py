"""`hillobs export`: observers for other programs."""

from __future__ import annotations

from pathlib import Path

import click

from ..export.files import save_c
from ..export.pages import export_page
from ..export.prepare import exported
from ..files.errors import ScenarioError
from ..files.numbers import parse_number
from ..laboratory.mechanisms.reading import read_mechanism
from ..laboratory.muscles import read_muscles
from ..laboratory.subject import subject_of
from ..scenarios.layers import Value
from .reports.number import counted
from .reports.written import written
from .shell.options import corrected_option, observer_option, scenario_argument, set_option, whole_option
from .shell.own_observers import loaded
from .shell.terminal import say

_AT_SAMPLES = "which move at samples only"


@click.group()
def export() -> None:
    """Write an observer as C for a controller board, or a closed loop as a page for a browser."""


@export.command()
@click.option("--observer", required=True, metavar="NAME|FILE.py:NAME", help="The observer; a file of yours is run.")
@click.option("--period", required=True, metavar="T", help="From sample to sample: s with muscles in SI, else in τ.")
@click.option("--scenario", metavar="SCENARIO|FILE.toml", help="Numbers of a scenario, in the paper's units.")
@click.option("--muscles", metavar="FILE.toml", help="A pair of muscles in SI, see docs/recordings.md.")
@click.option("--mechanism", metavar="FILE.toml", help="Or joints and muscles, see docs/mechanisms.md.")
@corrected_option(default=True)
@set_option("Change a number, e.g. high_gain.eps_h=0.05.")
@whole_option("--substeps", 1, "RK4 steps from sample to sample; by the rule of docs/gains.md if not given.")
@click.option("--float", "single", is_flag=True, help="Numbers are float, not double.")
@click.option("--out", required=True, metavar="DIR", help="Where the files are written.")
def c(
    observer: str,
    period: str,
    scenario: str | None,
    muscles: str | None,
    mechanism: str | None,
    corrected: bool,
    changes: dict[str, Value],
    substeps: int | None,
    single: bool,
    out: str,
) -> None:
    """Write an observer as C99: NAME.h and NAME.c, a program that reads CSV, a page, a file for CMake."""
    if sum(source is not None for source in (scenario, muscles, mechanism)) > 1:
        raise ScenarioError("numbers come from --scenario, --muscles or --mechanism, one of them")
    (chosen,) = loaded([observer]) or [observer]
    subject = None
    if mechanism is not None:
        subject = subject_of(read_mechanism(mechanism))
    elif muscles is not None:
        subject = subject_of(read_muscles(muscles))
    T = parse_number("--period", period)
    manifest = exported(chosen, T, scenario or "paper-clean", subject, changes, corrected, substeps)
    paths = save_c(manifest, Path(out), single)
    steps = f"{counted(manifest.substeps, 'RK4 step')} from sample to sample" if manifest.substeps else _AT_SAMPLES
    say(f"{manifest.label}: a state of {len(manifest.state)} numbers, {steps}")
    say(written(paths))


@export.command()
@scenario_argument("paper-noisy")
@observer_option()
@corrected_option(default=False)
@set_option("Change a number, e.g. plant.m=1.2, before the page is written.")
@click.option("--out", required=True, metavar="FILE.html", help="Where the page is written.")
def page(scenario: str, observers: tuple[str, ...], corrected: bool, changes: dict[str, Value], out: str) -> None:
    """Write a scenario as one HTML file that needs no server: its numbers can be moved, and all runs again at once."""
    say(written([export_page(scenario, out, loaded(observers), changes, corrected)]))
