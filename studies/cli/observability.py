"""`hillobs observability`: what some sensors determine at a point, along a run, over a map."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import click
import xarray as xr
from click.core import ParameterSource

from ...observers.observability import TOLERANCE
from ..files.datasets.netcdf import save_netcdf
from ..files.errors import ScenarioError
from ..files.numbers import parse_number
from ..files.pictures import figure_paths
from ..files.quote import shown
from ..files.writing import refuse_overwriting, writable_folder
from ..laboratory.mechanisms.reading import read_mechanism
from ..laboratory.subject import subject_of
from ..observability.map import along as rank_along
from ..observability.map import axis_ranges, over
from ..observability.point import Answer, answer, rest_point, start_point
from ..observability.question import Question, pose, pose_mechanism
from ..scenarios.layers import Value
from ..scenarios.prepare import prepare
from .reports.observability import answer_as_json, answer_table, details, ranks_along, ranks_over, summary
from .reports.written import written
from .shell.options import set_option, whole_option
from .shell.progress import bar
from .shell.scenario_arguments import scenario_argument
from .shell.tables import print_table
from .shell.terminal import complain, say

# a rank that is not full is no failure, but a script must see it
_DEFICIENT = 1
# with Lie derivatives up to 2 every unknown constant has appeared in the paper's outputs
_LEAST_ORDER = 2


@click.command()
@click.pass_context
@scenario_argument("paper-clean")
@click.option(
    "--at", "place", metavar="x1=..,x3=..", help="The point; the rest is the scenario's at τ = 0 (a mechanism at rest)."
)
@click.option(
    "--mechanism", metavar="FILE.toml", help="Joints and muscles instead of a scenario, at rest; exact names."
)
@click.option(
    "--outputs", help="Sensors: x1,F1,F2 of x1, x2, F1, F2, L_C1, L_C2; of a mechanism all joints and muscles."
)
@click.option("--unknown", default="none", show_default=True, help="Unknown: none, u (Δ, u1, u2) or a (Δ, a1, a2).")
@whole_option("--signals", 0, "Unknowns as signals: derivatives up to S are unknown too.", default=0, metavar="S")
@click.option("--parameters", metavar="A,B", help="Numbers of muscles, unknown too: muscle1 for all, or muscle1.k.")
@whole_option("--order", 0, "Highest Lie derivative; n − 1 by default (maps, runs: as many as add rank).", metavar="K")
@click.option("--tolerance", metavar="T", help="Singular values below this part of the largest are 0.")
@click.option("--along", is_flag=True, help="Rank along the run of the scenario, written to --out.")
@click.option("--map", "axes", metavar="A,B", help="Rank over two coordinates, such as x3,x4 or x1,tension, to --out.")
@set_option("Change a number of the scenario.")
@click.option("--json", "as_json", is_flag=True, help="The answer as JSON.")
@click.option("--out", default="results", show_default=True, metavar="DIR", help="Where maps and runs are written.")
def observability(
    ctx: click.Context,
    scenario: str,
    place: str | None,
    mechanism: str | None,
    outputs: str | None,
    unknown: str,
    signals: int,
    parameters: str | None,
    order: int | None,
    tolerance: str | None,
    along: bool,
    axes: str | None,
    changes: dict[str, Value],
    as_json: bool,
    out: str,
) -> None:
    """Say what these sensors determine at a point of SCENARIO; exit code 0 for full rank, 1 for less."""
    sensors = None if outputs is None else _names(outputs)
    limit, numbers = _tolerance(tolerance), _names(parameters or "")
    if numbers and (along or axes is not None):
        raise ScenarioError("--parameters asks at one point, and goes without --along and --map")
    if mechanism is not None:
        named = ctx.get_parameter_source("scenario") is not ParameterSource.DEFAULT
        if named or along or axes is not None or changes:
            raise ScenarioError("a SCENARIO, --along, --map and --set go without --mechanism: it has one point")
        sys.exit(_of_mechanism(mechanism, sensors, unknown, order, signals, numbers, limit, place or "", as_json))
    prepared = prepare(scenario, None, changes)
    question = pose(prepared, sensors, unknown, order, signals, numbers)
    here = answer(question, start_point(prepared) | _place(place or "", question), limit)
    names = [] if axes is None else axes.split(",")
    if axes is not None:
        axis_ranges(question, names, here.point)
    folder = Path(out)
    stem = f"{prepared.scenario.name}-observability"
    keys = ["along"] * along + ([] if axes is None else [_map_key(names)])
    if keys:
        writable_folder(folder)
        refuse_overwriting(path for key in keys for path in _paths(folder, stem, key))
    _tell(question, here, limit, as_json)
    if order is None:
        # orders beyond those that add rank at the point would only cost the compiler time
        enough = max(_LEAST_ORDER, here.verdict.ranks.index(here.verdict.rank))
        question = pose(prepared, question.sensors, unknown, min(enough, question.order), signals)
    # JSON stands alone on its stream
    tell = complain if as_json else say
    if along:
        with bar("along the run") as advance:
            data = rank_along(prepared, question, limit, advance)
            paths = _write(data, None, folder, stem, "along")
        tell(f"along the run, {ranks_along(data)}")
        tell(written(paths))
    if axes is not None:
        with bar("over the map") as advance:
            data = over(question, names, here.point, tolerance=limit, progress=advance)
            paths = _write(data, question, folder, stem, _map_key(names))
        tell(f"over the map, {ranks_over(data)}")
        tell(written(paths))
    sys.exit(0 if here.verdict.full else _DEFICIENT)


def _of_mechanism(
    mechanism: str,
    sensors: list[str] | None,
    unknown: str,
    order: int | None,
    signals: int,
    numbers: list[str],
    limit: float,
    place: str,
    as_json: bool,
) -> int:
    """The answer for a mechanism at rest, and the exit code."""
    subject = subject_of(read_mechanism(mechanism))
    question = pose_mechanism(subject, sensors, unknown, order, signals, numbers)
    here = answer(question, rest_point(subject, question) | _place(place, question), limit)
    _tell(question, here, limit, as_json)
    return 0 if here.verdict.full else _DEFICIENT


def _tell(question: Question, here: Answer, limit: float, as_json: bool) -> None:
    if as_json:
        say(*answer_as_json(question, here, limit).split("\n"))
        return
    say(summary(question, here), "")
    print_table(answer_table(question, here))
    say(*details(question, here, limit))


def _names(typed: str) -> list[str]:
    return [name.strip() for name in typed.split(",") if name.strip()]


def _place(typed: str, question: Question) -> dict[str, float]:
    """`x1=2.7,x3=2.01` as numbers by name."""
    valid = [*question.block.x, *question.block.u]
    place: dict[str, float] = {}
    for part in (part.strip() for part in typed.split(",") if part.strip()):
        name, equals, value = part.partition("=")
        if name in place:
            raise ScenarioError(f"--at gives {name} twice")
        if not equals or name not in valid:
            raise ScenarioError(f"--at takes NAME=VALUE with the names {', '.join(valid)}, not {shown(part)}")
        place[name] = parse_number(f"--at {name}", value)
    return place


def _tolerance(typed: str | None) -> float:
    limit = TOLERANCE if typed is None else parse_number("--tolerance", typed)
    if not 0 < limit < 1:
        raise ScenarioError(f"--tolerance must be between 0 and 1, not {limit:g}")
    return limit


def _write(data: xr.Dataset, question: Question | None, folder: Path, stem: str, key: str) -> list[Path]:
    """The result and its figure: of a map, which is drawn for its question, or along a run."""
    from ..figures.observability import along_figure, map_figure  # here: matplotlib takes as long to come as a run
    from ..figures.page import write_figures

    path, *_ = _paths(folder, stem, key)
    save_netcdf(data, path)
    figure = along_figure(data) if question is None else map_figure(data, question)
    return [path, *write_figures({key: figure}, folder, stem)]


def _paths(folder: Path, stem: str, key: str) -> list[Path]:
    """The files of a map or a run: the result and its figure."""
    return [folder / f"{stem}-{key}.nc", *figure_paths(folder, stem, [key])]


def _map_key(coordinates: Sequence[str]) -> str:
    return f"map-{'-'.join(coordinates)}"
