"""`hillobs import`: an OpenSim model as a mechanism file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import click
from click.core import ParameterSource

from ..files.errors import ScenarioError, in_file
from ..files.numbers import parse_number
from ..files.quote import short, shown
from ..files.writing import write_whole
from ..laboratory.mechanisms.from_opensim import mechanism_from
from ..laboratory.mechanisms.writing import mechanism_text
from ..laboratory.opensim.model import FitRequest, read_model
from ..laboratory.opensim.paths import Polynomial
from ..laboratory.path_fit.fit import LEAST_ORDER, MOST_ORDER, Fitted
from ..laboratory.path_fit.fit import fit as fit_in_opensim
from .reports.importing import fit_notes, fit_table, notes, tables
from .reports.written import written
from .shell.options import complete_files, whole_option
from .shell.places import toml_place
from .shell.progress import bar
from .shell.tables import print_table
from .shell.terminal import say


def _by_name(example: str, value: Callable[[str, str], object]) -> Callable[..., dict[str, object]]:
    """What is typed as NAME=VALUE, by name; `value` reads the latter."""

    def read(ctx: click.Context, param: click.Parameter, typed: tuple[str, ...]) -> dict[str, object]:
        found: dict[str, object] = {}
        for words in typed:
            name, equals, text = words.partition("=")
            if not (name and equals):
                raise ScenarioError(f"--{param.name} must be such as {example}, not {shown(words)}")
            if (name := name.strip()) in found:
                raise ScenarioError(f"--{param.name} {short(name)} is given twice")
            found[name] = value(f"--{param.name} {name}", text.strip())
        return found

    return read


def _limits(what: str, text: str) -> tuple[float, float]:
    low, colon, high = text.partition(":")
    if not colon:
        raise ScenarioError(f"{what} must be LOW:HIGH, not {shown(text)}")
    return parse_number(what, low), parse_number(what, high)


@click.command("import")
@click.argument("model", metavar="MODEL.osim", shell_complete=complete_files)
@click.option(
    "--paths",
    metavar="FILE.xml",
    shell_complete=complete_files,
    help="Lengths as polynomials, a FunctionBasedPathSet, if the model has none.",
)
@click.option(
    "--lock",
    "lock",
    multiple=True,
    metavar="JOINT=VALUE",
    callback=_by_name("shoulder=-0.1", parse_number),
    help="Hold a joint or a coordinate, in rad or m: shoulder=-0.1; may be repeated.",
)
@click.option(
    "--range",
    "range",
    multiple=True,
    metavar="JOINT=LOW:HIGH",
    callback=_by_name("elbow=0.1:2.2", _limits),
    help="What a joint may be, if not what the model says: elbow=0.1:2.2; may be repeated.",
)
@click.option("--muscles", metavar="A,B,…", help="Only these muscles.")
@click.option("--fit", is_flag=True, help="Let OpenSim fit polynomials for muscles that have none, over the ranges.")
@whole_option("--order", LEAST_ORDER, "Of the polynomials of --fit.", default=5, most=MOST_ORDER)
@click.option("--out", metavar="FILE.toml", shell_complete=complete_files, help="Where the mechanism is written.")
@click.pass_context
def import_(
    ctx: click.Context,
    model: str,
    paths: str | None,
    lock: dict[str, float],
    range: dict[str, tuple[float, float]],
    muscles: str | None,
    fit: bool,
    order: int,
    out: str | None,
) -> None:
    """Read bodies, joints, muscles and polynomial paths of an OpenSim model as a mechanism, without OpenSim.

    What was taken is printed, and what was not; with --out it is written as a mechanism file, to be edited. Only --fit
    needs OpenSim: pip install 'hillobs[opensim]'.
    """
    only = [name for name in map(str.strip, (muscles or "").split(",")) if name]
    if muscles is not None and not only:
        raise ScenarioError("--muscles must be names with commas between")
    if not fit and ctx.get_parameter_source("order") is not ParameterSource.DEFAULT:
        raise ScenarioError("--order is that of --fit, which is not asked for")
    place = None if out is None else toml_place(out)
    fits: list[Fitted] = []

    def fitted(request: FitRequest) -> Mapping[str, Polynomial]:
        with bar("fitting"):
            fits.append(fit_in_opensim(request, order))
        return fits[0].polynomials

    way = fitted if fit else None
    read = read_model(Path(model), None if paths is None else Path(paths), lock, only, range, way)
    with in_file(model):
        mechanism = mechanism_from(read, Path(model).name)
    for table in tables(read, mechanism):
        print_table(table)
    for done in fits:
        print_table(fit_table(done))
        say(*fit_notes(done))
    if fit and not fits:
        say("--fit has nothing to do: all muscles have polynomials")
    say(*notes(read, mechanism))
    if place is not None:
        write_whole(place, mechanism_text(mechanism).encode())
        say(written([place]))
