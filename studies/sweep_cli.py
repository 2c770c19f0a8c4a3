"""`hillobs sweep`: a scenario over parameters and seeds."""

from __future__ import annotations

import contextlib
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

import click

from .quote import escaped
from .terminal import bar, complain, counted, print_table, user_errors

if TYPE_CHECKING:
    import xarray as xr

_INTERRUPTED, _NUMERICAL = 128, 1


@click.command()
@click.argument("scenario", default="paper-noisy", metavar="[SCENARIO|FILE.toml]")
@click.option("--over", multiple=True, metavar="PATH=VALUES", help="0.1,0.2 or lin:LOW:HIGH:COUNT or log:….")
@click.option("--seeds", default="1", show_default=True, metavar="N", help="Runs per point, with the seeds 0 to N − 1.")
@click.option("--zip", "zipped", is_flag=True, help="The i-th values go together, instead of all combinations.")
@click.option("--design", metavar="KIND:N", help="N points of a design in the ranges: latin:N or sobol:N.")
@click.option("--observer", "observers", multiple=True, metavar="NAME", help="Only this observer; may be repeated.")
@click.option("--set", "settings", multiple=True, metavar="PATH=VALUE", help="Change a number of the scenario.")
@click.option("--out", metavar="FILE.nc", help="Where result and figures go; an unfinished sweep goes on there.")
@click.option(
    "--quantity", "quantities", multiple=True, metavar="NAME", help="Show this one: x2, Delta, …; repeatable."
)
@click.option("--no-figures", is_flag=True, help="Write no figures.")
@click.option("--workers", metavar="N", help="Threads, or processes of a local cluster; one per core by default.")
@click.option("--baseline", metavar="NAME", help="Processors to compile for: this one; for a cluster, a class of them.")
@click.option(
    "--cluster", metavar="ADDRESS|local", help="Run on the dask scheduler at tls://HOST:PORT, or on one made here."
)
@click.option("--yes", is_flag=True, help="Do not ask before a very large sweep.")
def sweep(
    scenario: str,
    over: tuple[str, ...],
    seeds: str,
    zipped: bool,
    design: str | None,
    observers: tuple[str, ...],
    settings: tuple[str, ...],
    out: str | None,
    quantities: tuple[str, ...],
    no_figures: bool,
    workers: str | None,
    baseline: str | None,
    cluster: str | None,
    yes: bool,
) -> None:
    """Run SCENARIO for all values of some parameters and many seeds; print where the errors are smallest."""
    with user_errors():
        from .axes import parse_axis
        from .cluster import ClusterError
        from .files import writable_folder
        from .pace import Pace
        from .plan import MANY_RUNS, plan
        from .scenario import parse_change
        from .sweep import engine, sweep_planned
        from .sweep_report import SHOWN, check_quantities, notes, optimum
        from .table import ScenarioError

        check_quantities(quantities)
        axes = dict(parse_axis(text) for text in over)
        if len(axes) < len(over):
            raise ScenarioError("a path is given to --over twice")
        if zipped and design:
            raise ScenarioError("--zip and --design exclude each other")
        kind, _, samples = (design or ("zip:0" if zipped else "grid:0")).partition(":")
        wanted = plan(
            scenario,
            axes,
            _whole("--seeds", seeds, 1),
            list(observers) or None,
            dict(parse_change(text) for text in settings),
            kind,
            _whole("--design", samples, 0),
        )
        if wanted.runs > MANY_RUNS and not yes:
            raise ScenarioError(f"{wanted.runs:,} runs are more than {MANY_RUNS:,}; say --yes if they are meant")
        count = None if workers is None else _whole("--workers", workers, 1)
        path = None if out is None else writable_folder(Path(out).parent) / Path(out).name
        with _signals(path), engine(count, cluster) as (compute, usual), counted("runs", wanted.runs) as advance:
            pace = Pace(advance)
            try:
                dataset = sweep_planned(wanted, path, compute, baseline or usual, pace)
            except ClusterError as error:
                raise ClusterError(f"{error}{_kept(path)}") from error
        for note in (*pace.sentences(), *notes(dataset)):
            click.echo(note)
        print_table(optimum(dataset, quantities or SHOWN))
        if path is not None:
            click.echo(_written(dataset, path, quantities, no_figures))
    if dataset.failed_at.notnull().any() or dataset.plant_failed_at.notnull().any():
        sys.exit(_NUMERICAL)


def _written(dataset: xr.Dataset, path: Path, quantities: tuple[str, ...], no_figures: bool) -> str:
    """Draw the figures beside the result, and say where both are."""
    written = escaped(f"written to {path}")
    if no_figures:
        return written
    from .sweep_figures import SHOWN, save_sweep_figures

    with bar("drawing"):
        drawn, sentence = save_sweep_figures(dataset, path.parent, path.stem, quantities or SHOWN)
    names = "".join(f", {figure.name} and .pdf" for figure in drawn if figure.suffix == ".png")
    return f"{sentence}\n{written}{names}".lstrip()


def _whole(option: str, text: str, least: int) -> int:
    from .table import ScenarioError

    if not text.isascii() or not text.isdigit() or len(text) > 12 or int(text) < least:
        raise ScenarioError(f"{option} must be a whole number of at least {least}, not {text[:40]!r}")
    return int(text)


@contextlib.contextmanager
def _signals(out: Path | None) -> Iterator[None]:
    """Ctrl-C, TERM and HUP end the sweep between two parts' slices, with a sentence and 128 + the signal's number."""

    def end(number: int, frame: FrameType | None) -> None:
        raise _EndedError(number)

    watched = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.signal(number, end) for number in watched}
    try:
        yield
    except _EndedError as ended:
        complain(f"stopped{_kept(out)}")
        sys.exit(_INTERRUPTED + ended.number)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _kept(out: Path | None) -> str:
    """What is left of a sweep that ends too early."""
    if out is None or not out.with_name(f"{out.name}.parts").exists():
        return ""
    return f"; what is done is kept in {out}.parts, the same command goes on"


class _EndedError(BaseException):
    """A signal has come; like KeyboardInterrupt, nothing that catches errors on the way may keep it."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number
