"""What every command says and how: tables, progress, one sentence for a mistake."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import sys
from collections.abc import Callable, Iterator

import click
from rich.console import Console, RenderableType
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from ....codegen.building import told_of_builds
from ....codegen.cache import BuildError
from ....codegen.system.room import has_room
from ....model.errors import Error
from ...files.quote import escaped

# exit codes: numbers that are not finite, a user's mistake
NUMERICAL, USAGE = 1, 2
_LIBRARY = 100_000_000  # bytes: more than the largest library that a command loads
# columns of a table in a pipe or a file, where nobody wraps lines
_PIPE_WIDTH = 120


def say(*lines: str, err: bool = False) -> None:
    """Lines on standard output: what others have named smuggles neither control characters nor lines into them."""
    for line in lines:
        click.echo(escaped(line), err=err)


def print_table(table: Table) -> None:
    """A table and a blank line, in pieces side by side as the terminal is wide; no number is cut.

    Through click: rich would end the program when a pipe closes.
    """
    console = Console()
    if not console.is_terminal:
        console.width = max(console.width, _PIPE_WIDTH)
    for piece in pieces(table, console):
        with console.capture() as text:
            console.print(piece, crop=False, overflow="ignore")
        click.echo(text.get())


def pieces(table: Table, console: Console) -> Iterator[Table]:
    """The table in groups of columns that fit, each beside the first column."""
    chosen: list[int] = []
    for i in range(1, len(table.columns)):
        if chosen and _width(_with_columns(table, [*chosen, i]), console) > console.width:
            yield _with_columns(table, chosen)
            chosen = []
        chosen.append(i)
    yield _with_columns(table, chosen)


def _with_columns(table: Table, chosen: list[int]) -> Table:
    """A table with the first column and those chosen of the others, its words as they are: no markup, no controls."""
    part = copy.copy(table)
    part.title = None if table.title is None else _plain(table.title)
    part.columns = [
        dataclasses.replace(column, _index=i, header=_plain(column.header), _cells=list(map(_plain, column.cells)))
        for i, column in enumerate(table.columns[j] for j in (0, *chosen))
    ]
    return part


def _plain(words: RenderableType) -> Text:
    """Words without markup, which names with brackets would be, and without control characters; a heading has lines."""
    lines = str(words).split("\n")
    return Text("\n".join(map(escaped, lines)), style=words.style if isinstance(words, Text) else "")


def _width(table: Table, console: Console) -> int:
    unlimited = console.options.update(max_width=10 * _PIPE_WIDTH)
    return console.measure(table, options=unlimited).maximum


@contextlib.contextmanager
def bar(what: str) -> Iterator[Callable[[float], None]]:
    """A progress bar on the terminal's error stream, which says when it compiles; without a terminal only that."""
    words = escape(escaped(what))
    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as progress:
        task = progress.add_task(words, total=1.0)
        with _told(progress, lambda sentence: progress.update(task, description=escape(sentence) or words)):
            yield lambda done: progress.update(task, completed=done)


@contextlib.contextmanager
def counting(unit: str, total: int) -> Iterator[Callable[[int, int], None]]:
    """The same with rate and remaining time."""
    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.description}"),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as progress:
        task = progress.add_task(unit, total=total, rate="")

        def advance(done: int, of: int) -> None:
            speed = progress.tasks[0].speed
            progress.update(task, completed=done, total=of, rate=f"{speed:,.0f}/s" if speed else "")

        with _told(progress, lambda sentence: progress.update(task, description=escape(sentence) or unit)):
            yield advance


def _told(progress: Progress, building: Callable[[str], None]) -> contextlib.AbstractContextManager[None]:
    """Compilations are said in the bar, or as a line where there is none."""

    def line(sentence: str) -> None:
        if sentence:
            complain(sentence)

    return told_of_builds(line if progress.disable else building)


@contextlib.contextmanager
def user_errors() -> Iterator[None]:
    """A user's mistake as one sentence and exit code 2."""
    try:
        yield
    except BuildError as error:  # the compiler's own words take several lines
        say(*f"hillobs: {error}".splitlines(), err=True)
        sys.exit(USAGE)
    except Error as error:
        complain(str(error))
        sys.exit(USAGE)
    except Exception as error:
        # for want of memory a library may seem not to be installed, or a number out of range
        if not isinstance(error, MemoryError) and has_room(_LIBRARY):
            raise
        words = error if isinstance(error, MemoryError) else ""  # NumPy says how much it asked for
        complain(f"there is not enough memory. {words}".rstrip(". "))
        sys.exit(USAGE)


def complain(sentence: str) -> None:
    """A sentence, on one line of the error stream."""
    with contextlib.suppress(OSError):  # without a listener the exit code says it
        say(f"hillobs: {sentence}", err=True)
