"""A plain table under a title."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rich.table import Table
from rich.text import Text


def plain_table(title: str, head: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> Table:
    """The first columns, as many as `words`, are words. Text, because labels like [dotla] are no markup."""
    table = Table(title=title, title_justify="left", box=None, padding=(0, 1, 0, 0))
    for i, name in enumerate(head):
        table.add_column(Text(name), justify="left" if i < words else "right", no_wrap=i == 0)
    for row in rows:
        table.add_row(*map(Text, row))
    return table
