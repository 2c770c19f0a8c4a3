"""Tables on a terminal: in pieces side by side, where it is not wide enough."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Iterator

from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

from ...files.quote import escaped
from .terminal import write

# columns of a table in a pipe or a file, where nobody wraps lines
_PIPE_WIDTH = 120


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
        write(text.get())


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
