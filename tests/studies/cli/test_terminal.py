"""Tables fit the terminal they are printed on, and compilations are told."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console
from rich.table import Table

from hillobs.codegen.building import building, told_of_builds
from hillobs.studies.cli.shell.tables import pieces


def table_of(names: list[str], rows: int) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0))
    table.add_column("", no_wrap=True)
    for name in names:
        table.add_column(name, justify="right", no_wrap=True)
    for row in range(rows):
        table.add_row(f"row {row}", *(f"{name}{row}" for name in names))
    return table


def printed(table: Table, width: int) -> list[list[str]]:
    """The lines of each piece."""
    console = Console(width=width, force_terminal=True, color_system=None)
    lines = []
    for piece in pieces(table, console):
        with console.capture() as text:
            console.print(piece, crop=False, overflow="ignore")
        lines.append(text.get().splitlines())
    return lines


@given(st.lists(st.text("abcxyz", min_size=1, max_size=12), max_size=12), st.integers(0, 3), st.integers(24, 120))
def test_no_line_is_wider_than_the_terminal_and_no_cell_is_lost(names: list[str], rows: int, width: int) -> None:
    """A row name and a column take 20 places at most."""
    found = printed(table_of(names, rows), width)
    assert all(len(line.rstrip()) <= width for piece in found for line in piece)
    heads = list(itertools.chain.from_iterable(piece[0].split() for piece in found if piece))
    assert heads == names
    for row in range(rows):
        cells = [piece[1 + row].split()[2:] for piece in found]
        assert list(itertools.chain.from_iterable(cells)) == [f"{name}{row}" for name in names]
        assert all(piece[1 + row].startswith(f"row {row}") for piece in found)


def test_a_table_that_fits_is_one_piece() -> None:
    assert len(printed(table_of(["x1", "x2", "x3"], 2), 80)) == 1


def test_who_asks_is_told_when_a_compilation_begins_and_ends() -> None:
    heard: list[str] = []
    with building({"blocks": [{"name": "a"}]}, "gcc"), told_of_builds(heard.append):
        pass
    assert heard == []
    five = {"blocks": [{"name": name} for name in "abcde"]}
    with told_of_builds(heard.append), pytest.raises(ValueError, match="broken"), building(five, "gcc"):
        raise ValueError("broken")
    assert heard == ["compiling a, b, c and 2 more with gcc: once, then the library is kept", ""]
