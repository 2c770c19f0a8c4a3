"""What is before the numbers of a table: names, units, delimiter; of CSV and of OpenSim's .sto and .mot."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass

from ..files.errors import RecordingError
from ..files.numbers import GAP, NUMBER
from ..files.quote import shown
from .units import find_unit

_MOST_COLUMNS = 10_000
# OpenSim's headers have ten lines, those of laboratories a page
_LONGEST_HEADER = 1_000
_UNITS_LINE = "units:"
# blanks of other scripts are text
BLANKS = " \t"
_PLAIN = re.compile(r'"[^"]*"|[^"]*')


@dataclass(frozen=True)
class Header:
    """The head of a table: a label and a unit ("" where none is given) per column, and how many lines it took.

    `delimiter` is one character, or " " for any number of blanks and tabs. `promised` is what an .sto file says of
    its number of rows, `in_degrees` whether what turns is in degrees there.
    """

    labels: tuple[str, ...]
    units: tuple[str, ...]
    delimiter: str
    lines: int
    promised: int | None = None
    remarks: tuple[str, ...] = ()
    in_degrees: bool = False


def read_header(lines: Sequence[str], opensim: bool) -> Header:
    """The header at the beginning of a file. RecordingError if there is none."""
    header = _sto(lines) if opensim else _csv(lines)
    if len(header.labels) > _MOST_COLUMNS:
        raise RecordingError(f"row {header.lines} has more than {_MOST_COLUMNS:,} columns")
    if any(header.labels) and all(NUMBER.fullmatch(label) for label in header.labels if label):
        raise RecordingError(f"row {header.lines} holds numbers where the names of the columns should be")
    return header


def cells(line: str, delimiter: str) -> list[str]:
    """The cells of one line, without quotes and blanks around them. RecordingError if a quote stays open."""
    if delimiter == " ":
        return [cell for cell in line.replace("\t", delimiter).split(delimiter) if cell]
    texts = [cell.strip(BLANKS) for cell in line.split(delimiter)]
    if '"' not in line:
        return texts
    # a reader for each line takes five times as long; it is for cells with quotes or delimiters inside
    if all(_PLAIN.fullmatch(cell) for cell in texts):
        return [cell.strip('"').strip(BLANKS) for cell in texts]
    try:
        (row,) = csv.reader([line], delimiter=delimiter, skipinitialspace=True, strict=True)
    except (csv.Error, ValueError) as error:
        raise RecordingError("a quoted cell does not end where it should") from error
    return [cell.strip(BLANKS) for cell in row]


def cells_of_row(row: int, line: str, delimiter: str) -> list[str]:
    """The cells of one row of a file. RecordingError as in `cells`, with the number of the row."""
    try:
        return cells(line, delimiter)
    except RecordingError as error:
        raise RecordingError(f"row {row}: {error}") from error


def _csv(lines: Sequence[str]) -> Header:
    at = next((i for i, line in enumerate(lines) if line.strip() and not _comment(line)), None)
    if at is None:
        raise RecordingError("is empty: it has no row with names of columns")
    said = [words for words in map(_comment, lines[:at]) if words.lower().startswith(_UNITS_LINE)]
    delimiter = next((mark for mark in "\t;," if mark in lines[at]), " ")
    labels = cells_of_row(at + 1, lines[at], delimiter)
    units = _units(said[-1][len(_UNITS_LINE) :] if said else "", delimiter, len(labels))
    # a second row of units, as laboratories write it
    row = cells_of_row(at + 2, lines[at + 1], delimiter) if at + 1 < len(lines) else []
    if row and len(row) == len(labels) and _are_units(row):
        if any(units):
            raise RecordingError(f"row {at + 2} holds units, and so does a comment above it")
        units, at = tuple(cell.strip("[]()") for cell in row), at + 1
    return Header(tuple(labels), units, delimiter, at + 1)


def _sto(lines: Sequence[str]) -> Header:
    end = next((i for i, line in enumerate(lines[:_LONGEST_HEADER]) if line.strip().lower() == "endheader"), None)
    if end is None:
        raise RecordingError(f"has no line endheader among its first {min(len(lines), _LONGEST_HEADER):,}")
    pairs = (line.partition("=") for line in lines[:end])
    keys = {key.strip().lower(): value.strip() for key, _, value in pairs}
    if keys.get("datatype", "double").lower() != "double":
        raise RecordingError(f"its DataType is {shown(keys['datatype'])}; a recording holds double")
    at = next((i for i in range(end + 1, len(lines)) if lines[i].strip()), None)
    if at is None:
        raise RecordingError("has no row with names of columns after endheader")
    delimiter = "\t" if "\t" in lines[at].strip() else " "
    labels = cells_of_row(at + 1, lines[at].strip(), delimiter)
    counted = _whole(keys.get("ncolumns", ""))
    # files cut by hand keep their old numbers, and OpenSim 4.6 reads them; each row is checked against the names
    remarks = (
        (f"the header says nColumns={counted}, there are {len(labels)}",) if counted not in (None, len(labels)) else ()
    )
    in_degrees = keys.get("indegrees", "no").lower() == "yes"
    units, rows = ("",) * len(labels), _whole(keys.get("nrows", ""))
    return Header(tuple(labels), units, delimiter, at + 1, rows, remarks, in_degrees)


def _comment(line: str) -> str:
    """What a comment says, at least #; empty for other lines."""
    return line.strip().lstrip("#").strip() or "#" if line.strip().startswith("#") else ""


def _units(comment: str, delimiter: str, count: int) -> tuple[str, ...]:
    """The units of a comment, one for each column."""
    if not comment:
        return ("",) * count
    texts = cells(comment.strip(), delimiter)
    if len(texts) != count:
        raise RecordingError(f"the comment on units has {len(texts)} for {count} columns")
    return tuple(texts)


def _are_units(row: Sequence[str]) -> bool:
    texts = [cell.strip("[]()") for cell in row]
    first = next((text for text in texts if text), "1")
    return not NUMBER.fullmatch(first) and not GAP.fullmatch(first) and find_unit(first) is not None


def _whole(text: str) -> int | None:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 16 else None
