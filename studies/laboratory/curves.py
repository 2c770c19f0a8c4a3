"""Curves of a user: a CSV file with the columns curve, x, y, checked row by row, or the points themselves."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from pathlib import Path

from ...model.curves.curve_set import CurveSet
from ...model.curves.fit import TableError
from ...model.curves.tabulated import MOST_POINTS, TABLES, Points, Tables, tabulated
from ..files.errors import RecordingError, ScenarioError
from ..files.numbers import NUMBER
from ..files.quote import short, shown
from ..files.reading import cause, read_whole
from .header import cells_of_row
from .lines import text_of

SUFFIX = ".csv"
_COLUMNS = ["curve", "x", "y"]
_LARGEST_FILE = 4_000_000


def read_curves(path: Path) -> CurveSet:
    """The curve set of a file: columns curve, x, y and four curves, docs/curves.md. Equal points give the same set.

    ScenarioError names the file, and the row or curve that is wrong.
    """
    try:
        raw = read_whole(path, _LARGEST_FILE)
    except (OSError, ValueError) as error:
        raise ScenarioError(f"{path}: cannot be read: {cause(error)}") from error
    try:
        return tabulated(_tables(text_of(raw.removeprefix(b"\xef\xbb\xbf"))))
    except (RecordingError, TableError) as error:
        raise ScenarioError(f"{path}: {error}") from error


def tabulated_curves(points: Mapping[str, object]) -> CurveSet:
    """The same set from the points of the four curves: name → [[x, y], …]. ScenarioError says what is wrong."""
    if sorted(points) != sorted(TABLES):
        raise ScenarioError(f"must have the tables {', '.join(TABLES)}, not {shown(', '.join(points))}")
    try:
        return tabulated(Tables(**{name: _points(points[name]) for name in TABLES}))
    except (TypeError, OverflowError) as error:
        raise ScenarioError("tables must be lists of points [x, y]") from error
    except TableError as error:
        raise ScenarioError(str(error)) from error


def _points(points: object) -> Points:
    """Points as TOML and JSON have them; TypeError if they are something else."""
    if not isinstance(points, list):
        raise TypeError
    return tuple(map(_point_of, points))


def _point_of(point: object) -> tuple[float, float]:
    match point:
        case [int() | float() as x, int() | float() as y] if bool not in (type(x), type(y)):
            return float(x), float(y)
    raise TypeError


def _tables(text: str) -> Tables:
    points: dict[str, list[tuple[float, float]]] = {name: [] for name in TABLES}
    delimiter = ""
    for row, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        if not delimiter:
            delimiter = next((mark for mark in "\t;" if mark in line), ",")
            if (names := cells_of_row(row, line, delimiter)) != _COLUMNS:
                raise RecordingError(f"row {row}: its columns must be curve, x, y, not {shown(', '.join(names))}")
            continue
        name, point = _point(cells_of_row(row, line, delimiter), row)
        if len(points[name]) == MOST_POINTS:
            raise RecordingError(f"row {row}: {name} has more than {MOST_POINTS:,} points")
        points[name].append(point)
    if missing := [name for name, of_curve in points.items() if not of_curve]:
        raise RecordingError(f"has no points of {', '.join(missing)}")
    tables: dict[str, Points] = {name: tuple(of_curve) for name, of_curve in points.items()}
    return Tables(**tables)


def _point(row: list[str], at: int) -> tuple[str, tuple[float, float]]:
    if len(row) != len(_COLUMNS):
        raise RecordingError(f"row {at} has {len(row)} cells for the columns curve, x, y")
    name, *numbers = row
    if name not in TABLES:
        near = difflib.get_close_matches(short(name), TABLES, n=1)
        hint = f"the nearest is {near[0]}" if near else f"there are {', '.join(TABLES)}"
        raise RecordingError(f"row {at}: unknown curve {shown(name)}; {hint}")
    for column, text in zip(_COLUMNS[1:], numbers, strict=True):
        if not NUMBER.fullmatch(text):
            raise RecordingError(f"row {at}, column {column}: {shown(text)} is no number")
    x, y = map(float, numbers)
    return name, (x, y)
