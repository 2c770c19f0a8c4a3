"""Options that several commands have: how each is read, and how a shell completes it."""

from __future__ import annotations

from collections.abc import Iterable

import click
from click.shell_completion import CompletionItem

from ....observers import OBSERVERS
from ...estimate.bands.doubt import parse_doubt
from ...files.errors import ScenarioError
from ...files.numbers import NUMBER, number, typed_whole
from ...files.quote import shown
from ...scenarios.layers import Value
from ...scenarios.loops import all_paths
from ...scenarios.scenario import VALID_CHOICES, typed_changes
from ...sweep.axes import Values, parse_axis
from .scenario_arguments import Decorator

# unit → s; what ends in none of them has no unit
_SECONDS = {"ms": 1e-3, "s": 1.0, "": 1.0}


def observer_option() -> Decorator:
    """`--observer`, which may be repeated: a tuple of what is typed, for `own_observers.loaded`."""
    return click.option(
        "--observer",
        "observers",
        multiple=True,
        metavar="NAME|FILE.py:NAME",
        shell_complete=_complete_observers,
        help="Only this observer, or a Block of your own in a file, which is run; may be repeated.",
    )


def corrected_option(default: bool) -> Decorator:
    """`--corrected` and `--uncorrected`."""
    return click.option(
        "--corrected/--uncorrected",
        default=default,
        show_default=True,
        help="Correct the layers of the sliding mode observers, or not.",
    )


def mapping_option() -> Decorator:
    """`--map NAME=COLUMN`, which may be repeated: a tuple of texts."""
    return click.option(
        "--map", "maps", multiple=True, metavar="NAME=COLUMN", help="Name a column, e.g. position=block_x[mm]."
    )


def set_option(sentence: str) -> Decorator:
    """`--set PATH=VALUE` or a file of such, which may be repeated: a dict; of a path given twice the last counts."""
    return click.option(
        "--set",
        "changes",
        multiple=True,
        metavar="PATH=VALUE|FILE.toml",
        callback=_changes,
        shell_complete=_complete_paths,
        help=sentence,
    )


def over_option(sentence: str = "0.1,0.2 or lin:LOW:HIGH:COUNT or log:….") -> Decorator:
    """`--over PATH=VALUES`, which may be repeated: a dict."""
    return click.option(
        "--over",
        multiple=True,
        metavar="PATH=VALUES",
        callback=_axes,
        shell_complete=_complete_paths,
        help=sentence,
    )


def doubt_option() -> Decorator:
    """`--doubt NAME=SD`, which may be repeated, but not of one number: a dict."""
    return click.option(
        "--doubt",
        multiple=True,
        metavar="NAME=SD",
        callback=_doubts,
        help="How far a number may be off: optimal_fibre_length=3%, muscle1.F_max=50, force_bias=5N.",
    )


def whole_option(
    name: str, least: int, sentence: str, default: int | None = None, metavar: str = "N", most: int | None = None
) -> Decorator:
    """A whole number from `least` to `most`, strictly: no underscores, no digits of other scripts."""

    def read(ctx: click.Context, param: click.Parameter, typed: str | None) -> int | None:
        return None if typed is None else typed_whole(name, typed, least, most)

    usual = None if default is None else str(default)
    return click.option(
        name, default=usual, show_default=usual is not None, metavar=metavar, callback=read, help=sentence
    )


def seconds_option(name: str, sentence: str, default: str = "0") -> Decorator:
    """A time of 0 or more, in s: `20ms`, `0.02s` or `0.02`."""

    def read(ctx: click.Context, param: click.Parameter, typed: str) -> float:
        digits, factor = next(
            (typed.removesuffix(unit), factor) for unit, factor in _SECONDS.items() if typed.endswith(unit)
        )
        if not NUMBER.fullmatch(digits):
            raise ScenarioError(f"{name} must be a time in ms or s, such as 20ms or 0.02s, not {shown(typed)}")
        seconds = number(name, float(digits)) * factor
        if seconds < 0:
            raise ScenarioError(f"{name} must be 0 or more, not {shown(typed)}")
        return seconds

    return click.option(name, default=default, show_default=True, metavar="TIME", callback=read, help=sentence)


def complete_files(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of files, for a shell."""
    return [CompletionItem(incomplete, type="file")]


def _changes(ctx: click.Context, param: click.Parameter, typed: tuple[str, ...]) -> dict[str, Value]:
    return {path: value for text in typed for path, value in typed_changes(text).items()}


def _doubts(ctx: click.Context, param: click.Parameter, typed: tuple[str, ...]) -> dict[str, float | str]:
    doubts = dict(parse_doubt(text) for text in typed)
    if len(doubts) < len(typed):
        raise ScenarioError("a number is given to --doubt twice")
    return doubts


def _axes(ctx: click.Context, param: click.Parameter, typed: tuple[str, ...]) -> dict[str, Values]:
    axes = dict(parse_axis(text) for text in typed)
    if len(axes) < len(typed):
        raise ScenarioError("a path is given to --over twice")
    return axes


def _complete_observers(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    return [*_beginning(OBSERVERS, incomplete), CompletionItem(incomplete, type="file")]


def _complete_paths(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    path, equals, _ = incomplete.partition("=")
    if equals:
        return _beginning((f"{path}={value}" for value in VALID_CHOICES.get(path, ())), incomplete)
    paths = all_paths()
    return _beginning((f"{known}=" for known in (*VALID_CHOICES, *paths.groups(), *paths.parameters)), incomplete)


def _beginning(words: Iterable[str], incomplete: str) -> list[CompletionItem]:
    return [CompletionItem(word) for word in words if word.startswith(incomplete)]
