"""The command line: one function per command; `sweep` has a file of its own."""

from __future__ import annotations

import os
import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import click

from ..files.quote import escaped
from .estimate import estimate
from .sweep import sweep
from .terminal import USAGE, bar, complain, print_table, user_errors

if TYPE_CHECKING:
    import xarray as xr

    from .reports.observability import Asked

# exit codes; a rank that is not full is no failure, but a script must see it
_NUMERICAL, _DEFICIENT, _INTERRUPTED, _READER_GONE = 1, 1, 130, 141


def main() -> None:
    """Run the command line and exit: 0 done, 1 numbers failed or rank deficient, 2 wrong input, 130 interrupted."""
    # a closed stream is None; what it is given goes nowhere
    sys.stdout, sys.stderr = (stream or os.fdopen(_nowhere(), "w") for stream in (sys.stdout, sys.stderr))
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    warnings.showwarning = _show_warning
    stdout = sys.stdout
    try:
        commands(standalone_mode=False)
    except click.ClickException as error:
        complain(error.format_message())
        sys.exit(USAGE)
    except (click.Abort, KeyboardInterrupt):
        sys.exit(_INTERRUPTED)
    except OSError as error:
        _drop_output()
        complain(f"{error.filename or 'standard output'}: {error.strerror}")
        sys.exit(USAGE)
    except SystemExit:
        if sys.stdout is stdout:
            raise
        _drop_output()  # click has put it aside: its reader is gone
        sys.exit(_READER_GONE)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="hillobs", prog_name="hillobs")
def commands() -> None:
    """Observers for a pair of Hill muscles: states, unknown inputs and activations."""


commands.add_command(estimate)
commands.add_command(sweep)


@commands.command()
@click.argument("scenarios", nargs=-1, metavar="[SCENARIO|FILE.toml]...")
@click.option("--observer", "observers", multiple=True, metavar="NAME", help="Only this observer; may be repeated.")
@click.option("--set", "settings", multiple=True, metavar="PATH=VALUE", help="Change a number, e.g. plant.m=1.2.")
@click.option("--seed", metavar="N", help="Seed of the measurement noise.")
@click.option("--step", metavar="H", help="Integration step.")
@click.option("--out", default="results", show_default=True, metavar="DIR", help="Where results are written.")
@click.option("--no-figures", is_flag=True, help="Write no figures.")
def simulate(
    scenarios: tuple[str, ...],
    observers: tuple[str, ...],
    settings: tuple[str, ...],
    seed: str | None,
    step: str | None,
    out: str,
    no_figures: bool,
) -> None:
    """Simulate scenarios (the paper's two by default), print their measures, write results and figures."""
    failed = False
    with user_errors():
        from ..files.writing import writable_folder
        from ..scenarios.prepare import prepare
        from ..scenarios.scenario import parse_change
        from ..simulate.files import refuse_same_names, save
        from ..simulate.run import RunWarning, simulate_prepared
        from .reports.simulate import failures

        changes = dict(parse_change(text) for text in settings)
        for path, value in (("seed", seed), ("step", step)):
            if value is not None:
                changes |= dict([parse_change(f"{path}={value}")])
        names = scenarios or ("paper-clean", "paper-noisy")
        every = [prepare(name, list(observers) or None, changes) for name in names]
        refuse_same_names([prepared.scenario.name for prepared in every])
        folder = writable_folder(Path(out))
        for prepared in every:
            name = prepared.scenario.name
            with bar(f"{name}: simulating") as advance, warnings.catch_warnings():
                warnings.simplefilter("ignore", RunWarning)  # its reason is printed below
                dataset = simulate_prepared(prepared, advance)
            written = save(dataset, folder)
            if not no_figures:
                from ..figures.run import save_figures

                with bar(f"{name}: drawing"):
                    written += save_figures(dataset, folder, name)
            _print_report(dataset)
            click.echo(_written(written) + "\n")
            for sentence in failures(dataset):
                complain(sentence)
                failed = True
    if failed:
        sys.exit(_NUMERICAL)


@commands.command()
@click.argument("scenario")
def show(scenario: str) -> None:
    """Print SCENARIO as a complete, commented TOML file to start from."""
    with user_errors():
        from ..scenarios.show import show as text

        click.echo(text(scenario), nl=False)


@commands.command(name="list")
@click.argument("what", type=click.Choice(["all", "scenarios", "observers", "curves", "parameters"]), default="all")
def list_(what: str) -> None:
    """List scenarios, observers, curve sets, or parameters with default, unit and meaning."""
    with user_errors():
        from .reports.listing import listing

        for line in listing(what):
            click.echo(line)


@commands.command()
@click.argument("result", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Where figures are written; beside RESULT by default.")
def figures(result: Path, out: Path | None) -> None:
    """Draw the figures of RESULT.nc, a run, a sweep or estimates, again without a run."""
    with user_errors():
        from ..figures.estimate import save_sheet
        from ..figures.run import save_figures
        from ..figures.sweep.figures import save_sweep_figures
        from ..files.errors import ResultError
        from ..files.netcdf import load
        from ..files.writing import writable_folder

        dataset = load(result)
        # what a run, a sweep and estimates have
        if not {"x_hat", "failed_at", "activation_hat"} & set(dataset):
            raise ResultError(f"{result} cannot be drawn: it is no run, no sweep and no estimates")
        folder = writable_folder(out or result.parent)
        sentence = ""
        if "failed_at" in dataset:
            written, sentence = save_sweep_figures(dataset, folder, result.stem)
        else:
            written = (save_figures if "x_hat" in dataset else save_sheet)(dataset, folder, result.stem)
        if sentence:
            click.echo(sentence)
        if written:
            click.echo(_written(written))


@commands.command()
@click.option("--out", type=click.Path(path_type=Path), default=Path("results"), help="Where the figure is written.")
def curves(out: Path) -> None:
    """Draw the muscle's curves of every publication side by side; `list curves` describes them."""
    with user_errors():
        from ..figures.muscle_curves import curve_figure
        from ..figures.page import write_figures
        from ..files.writing import writable_folder

        click.echo(_written(write_figures({"sets": curve_figure()}, writable_folder(out), "curves")))


@commands.command()
@click.argument("scenario", default="paper-clean")
@click.option("--at", "place", metavar="x1=..,x3=..", help="The point; what is not given is the scenario's at τ = 0.")
@click.option("--outputs", default="x1,F1,F2", show_default=True, help="Sensors: x1, x2, F1, F2, L_C1, L_C2.")
@click.option("--unknown", default="none", show_default=True, help="Unknown: none, u (Δ, u1, u2) or a (Δ, a1, a2).")
@click.option("--signals", default="0", metavar="S", help="Unknowns as signals: derivatives up to S are unknown too.")
@click.option(
    "--order", metavar="K", help="Highest Lie derivative; n − 1 by default (maps and runs: as many as add rank)."
)
@click.option("--tolerance", metavar="T", help="Singular values below this part of the largest are 0.")
@click.option("--along", is_flag=True, help="Rank along the run of the scenario, written to --out.")
@click.option("--map", "axes", metavar="A,B", help="Rank over two coordinates, such as x3,x4 or x1,tension, to --out.")
@click.option("--set", "settings", multiple=True, metavar="PATH=VALUE", help="Change a number of the scenario.")
@click.option("--json", "as_json", is_flag=True, help="The answer as JSON.")
@click.option("--out", default="results", show_default=True, metavar="DIR", help="Where maps and runs are written.")
def observability(
    scenario: str,
    place: str | None,
    outputs: str,
    unknown: str,
    signals: str,
    order: str | None,
    tolerance: str | None,
    along: bool,
    axes: str | None,
    settings: tuple[str, ...],
    as_json: bool,
    out: str,
) -> None:
    """Say what these sensors determine at a point of SCENARIO; exit code 0 for full rank, 1 for less."""
    with user_errors():
        from ..files.writing import writable_folder
        from ..scenarios.scenario import parse_change
        from .reports.observability import answer_question, check_axes, write_along, write_map

        given = dict(parse_change(text) for text in settings)
        asked = answer_question(scenario, given, place, outputs, unknown, order, tolerance, signals)
        if axes is not None:
            check_axes(asked, axes)
        folder = Path(out)
        if along or axes is not None:
            writable_folder(folder)
        if as_json:
            click.echo(asked.json())
        else:
            _print_answer(asked)
        for wanted, write in ((along, write_along), (axes is not None, write_map)):
            if wanted:
                with bar("observability") as advance:
                    sentence, paths = write(asked, folder, axes or "", advance)
                click.echo(f"{sentence}\n{_written(paths)}", err=as_json)
    sys.exit(0 if asked.answer.verdict.full else _DEFICIENT)


@commands.command()
def errata() -> None:
    """Run the controller and the adaptive observer as printed beside the corrected ones."""
    with user_errors():
        from ..errata.run import errata as study
        from .reports.errata import tables

        with bar("errata") as advance:
            results = study(advance)
        for table in tables(results):
            print_table(table)


@commands.command()
def info() -> None:
    """Show versions, compiler, CPU and cache."""
    with user_errors():
        from .reports.listing import information

        for line in information():
            click.echo(line)


@commands.command()
def clean() -> None:
    """Empty the cache of compiled libraries."""
    with user_errors():
        from ...codegen.cache import clean_cache

        removed = clean_cache()
        click.echo(f"removed {len(removed)} files" if removed else "the cache was empty")


def _print_answer(asked: Asked) -> None:
    click.echo(asked.summary() + "\n")
    print_table(asked.table())
    for sentence in asked.details():
        click.echo(sentence)


def _print_report(dataset: xr.Dataset) -> None:
    from .reports.simulate import notes, tables

    about = dataset.attrs
    click.echo(escaped(f"{about['scenario']}, seed {about['seed']}: {about['description']}") + "\n")
    for title, table in tables(dataset):
        click.echo(title)
        print_table(table)
    for note in notes(dataset):
        click.echo(note)


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    complain(f"warning: {message}")


def _written(paths: list[Path]) -> str:
    """Where what was written is; figures are only counted."""
    data = [path.name for path in paths if path.suffix not in (".png", ".pdf")]
    drawn = (len(paths) - len(data)) // 2
    names = [*data, *([f"{drawn} figure{'s' if drawn > 1 else ''} as PNG and PDF"] if drawn else [])]
    return escaped(f"written to {paths[0].parent}/: {', '.join(names)}")


def _drop_output() -> None:
    """What is left in the buffer of standard output goes nowhere."""
    os.dup2(_nowhere(), sys.stdout.fileno())


def _nowhere() -> int:
    return os.open(os.devnull, os.O_WRONLY)
