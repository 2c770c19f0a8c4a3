"""Time series as CSV with units, or as OpenSim's .sto: numbers that read back bit for bit, whole or not at all."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...model.arrays import Array
from .writing import write_pieces

# rows that are text at a time: a few MB
_PIECE = 16_384


@dataclass(frozen=True, eq=False)
class Series:
    """A column: its name, its unit and its values."""

    name: str
    unit: str
    values: Array


def write_csv(path: Path, columns: Sequence[Series]) -> None:
    """Columns of one length as CSV, names with units such as `position [m]`, gaps empty. ResultError if not."""
    labels = [column.name if column.unit == "1" else f"{column.name} [{column.unit}]" for column in columns]
    write_pieces(path, _pieces(csv_text([labels]), columns, ",", or_empty))


def csv_text(rows: Iterable[Sequence[object]]) -> str:
    """Rows of cells as CSV."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def write_sto(path: Path, title: str, columns: Sequence[Series]) -> None:
    """Columns of one length, the first of them time, as OpenSim reads them; gaps are nan. ResultError if not."""
    rows = len(columns[0].values)
    head = [
        " ".join(title.split()) or "hillobs",
        "version=1",
        f"nRows={rows}",
        f"nColumns={len(columns)}",
        "inDegrees=no",
        "endheader",
        "\t".join(column.name for column in columns),
    ]
    write_pieces(path, _pieces("\n".join(head) + "\n", columns, "\t", _or_nan))


def _pieces(head: str, columns: Sequence[Series], delimiter: str, text: Callable[[float], str]) -> Iterator[bytes]:
    yield head.encode()
    for start in range(0, len(columns[0].values), _PIECE):
        block = np.stack([column.values[start : start + _PIECE] for column in columns], axis=1)
        yield "".join(_lines(block.tolist(), delimiter, text)).encode()


def _lines(rows: Iterable[list[float]], delimiter: str, text: Callable[[float], str]) -> Iterator[str]:
    for row in rows:
        yield delimiter.join(map(text, row)) + "\n"


def _or_nan(value: float) -> str:
    """The shortest text that reads back as the same number."""
    return repr(value).removesuffix(".0")


def or_empty(value: float) -> str:
    """The same; NaN is empty."""
    return "" if value != value else _or_nan(value)
