"""How far a command is: a bar on the error stream, which says when something is compiled."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ....codegen.building import told_of_builds
from ...files.quote import escaped
from .terminal import complain


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
