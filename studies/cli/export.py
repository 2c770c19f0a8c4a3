"""`hillobs export`: observers, and the plant they observe, for other programs."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path

import click

from ...codegen.targets.manifest import Manifest
from ..export.files import save_c, save_fmus
from ..export.pages import export_page
from ..export.plant import exported_plant
from ..export.prepare import exported
from ..files.errors import ScenarioError
from ..files.numbers import parse_number
from ..laboratory.mechanisms.reading import read_mechanism
from ..laboratory.muscles import read_muscles
from ..laboratory.subject import subject_of
from ..scenarios.layers import Value
from .reports.number import counted
from .reports.written import written
from .shell.options import corrected_option, observer_option, set_option, whole_option
from .shell.own_observers import loaded
from .shell.progress import bar
from .shell.scenario_arguments import scenario_argument
from .shell.terminal import say

_AT_SAMPLES = "which move at samples only"
_OPTIONS = (
    click.option(
        "--observer", required=True, metavar="NAME|FILE.py:NAME", help="The observer; a file of yours is run."
    ),
    click.option(
        "--period", required=True, metavar="T", help="From sample to sample: s with muscles in SI, else in τ."
    ),
    click.option("--scenario", metavar="SCENARIO|FILE.toml", help="Numbers of a scenario, in the paper's units."),
    click.option("--muscles", metavar="FILE.toml", help="A pair of muscles in SI, see docs/recordings.md."),
    click.option("--mechanism", metavar="FILE.toml", help="Or joints and muscles, see docs/mechanisms.md."),
    corrected_option(default=True),
    set_option("Change a number, e.g. high_gain.eps_h=0.05."),
    whole_option("--substeps", 1, "RK4 steps from sample to sample; by the rule of docs/gains.md if not given."),
)
_out_option = click.option("--out", required=True, metavar="DIR", help="Where the files are written.")


def _of_an_observer(command: Callable[..., None]) -> Callable[..., None]:
    """Options that say which observer is exported, and how; the command is given its manifest for them."""

    @functools.wraps(command)
    def with_manifest(
        observer: str,
        period: str,
        scenario: str | None,
        muscles: str | None,
        mechanism: str | None,
        corrected: bool,
        changes: dict[str, Value],
        substeps: int | None,
        **rest: bool | str,
    ) -> None:
        if sum(source is not None for source in (scenario, muscles, mechanism)) > 1:
            raise ScenarioError("numbers come from --scenario, --muscles or --mechanism, one of them")
        (chosen,) = loaded([observer]) or [observer]
        subject = None
        if mechanism is not None:
            subject = subject_of(read_mechanism(mechanism))
        elif muscles is not None:
            subject = subject_of(read_muscles(muscles))
        T = parse_number("--period", period)
        command(exported(chosen, T, scenario or "paper-clean", subject, changes, corrected, substeps), **rest)

    return functools.reduce(lambda wrapped, option: option(wrapped), reversed(_OPTIONS), with_manifest)


@click.group()
def export() -> None:
    """Write an observer for another program, or a closed loop as a page for a browser."""


@export.command()
@_of_an_observer
@click.option("--float", "single", is_flag=True, help="Numbers are float, not double.")
@_out_option
def c(manifest: Manifest, single: bool, out: str) -> None:
    """Write an observer as C99: NAME.h and NAME.c, a program that reads CSV, a page, a file for CMake."""
    paths = save_c(manifest, Path(out), single)
    say(_about(manifest))
    say(written(paths))


@export.command()
@_of_an_observer
@_out_option
def fmu(manifest: Manifest, out: str) -> None:
    """Write an observer as FMUs for Co-Simulation: NAME-fmi2.fmu and NAME-fmi3.fmu."""
    with bar("FMUs"):
        paths = save_fmus(manifest, Path(out))
    say(_about(manifest))
    say(written(paths))


@export.command()
@scenario_argument(default="paper-clean")
@set_option("Change a number, e.g. plant.m=1.2.")
@_out_option
def plant(scenario: str, changes: dict[str, Value], out: str) -> None:
    """Write the plant of a scenario with its controller as FMUs: what is true, and what sensors measure of it."""
    manifest = exported_plant(scenario, changes)
    with bar("FMUs"):
        paths = save_fmus(manifest, Path(out))
    say(f"{manifest.sentence}, a step each {manifest.period:g}")
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


def _about(manifest: Manifest) -> str:
    steps = f"{counted(manifest.substeps, 'RK4 step')} from sample to sample" if manifest.substeps else _AT_SAMPLES
    return f"{manifest.label}: a state of {len(manifest.state)} numbers, {steps}"
