"""What every command says and how: tables, progress, one sentence for a mistake."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import click

from ..files.quote import escaped

if TYPE_CHECKING:
    from rich.table import Table

USAGE = 2
# a narrow terminal may wrap the lines of a table, nothing may cut its numbers
_TABLE_WIDTH = 120


def print_table(table: Table) -> None:
    """A table and a blank line, through click: rich would end the program when a pipe closes."""
    from rich.console import Console

    console = Console()
    console.width = max(console.width, _TABLE_WIDTH)
    with console.capture() as text:
        console.print(table)
    click.echo(text.get())


@contextlib.contextmanager
def bar(what: str) -> Iterator[Callable[[float], None]]:
    """A progress bar on the terminal's error stream; nothing where there is no terminal."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as progress:
        task = progress.add_task(escape(escaped(what)), total=1.0)
        yield lambda done: progress.update(task, completed=done)


@contextlib.contextmanager
def counted(unit: str, total: int) -> Iterator[Callable[[int, int], None]]:
    """A progress bar with rate and remaining time; nothing where there is no terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn(unit),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as progress:
        task = progress.add_task("", total=total, rate="")

        def advance(done: int, of: int) -> None:
            speed = progress.tasks[0].speed
            progress.update(task, completed=done, total=of, rate=f"{speed:,.0f}/s" if speed else "")

        yield advance


@contextlib.contextmanager
def user_errors() -> Iterator[None]:
    """A user's mistake as one sentence and exit code 2."""
    from ...codegen.cache import BuildError
    from ...model.block import BlockError
    from ..files.errors import ClusterError, RecordingError, ResultError, ScenarioError

    try:
        yield
    except (ScenarioError, ResultError, RecordingError, BlockError, ClusterError) as error:
        complain(str(error))
        sys.exit(USAGE)
    except MemoryError as error:  # NumPy says how much it asked for
        complain(f"there is not enough memory. {error}".rstrip(". "))
        sys.exit(USAGE)
    except BuildError as error:  # the compiler's own words take several lines
        click.echo("hillobs: " + "\n".join(map(escaped, str(error).splitlines())), err=True)
        sys.exit(USAGE)


def complain(sentence: str) -> None:
    """A sentence on the error stream; file names cannot smuggle control characters into a terminal."""
    with contextlib.suppress(OSError):  # without a listener the exit code says it
        click.echo(f"hillobs: {escaped(sentence)}", err=True)
