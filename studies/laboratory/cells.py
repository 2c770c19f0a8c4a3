"""The numbers of a table, block by block: fast where all is well, cell by cell where something is not."""

from __future__ import annotations

import io
import math
import re

import numpy as np
from numpy.typing import NDArray

from ...model.arrays import Array
from ..files.errors import RecordingError
from ..files.numbers import GAP, NUMBER
from ..files.quote import shown
from .header import BLANKS, cells_of_row
from .lines import text_of

Rows = NDArray[np.int64]

_NUMERIC = b"0123456789+-.eE "
_BYTES = bytes(range(256))
# decimal commas as points, so that points are no numbers
_SWAPPED = str.maketrans(",.", ".,")


class Cells:
    """Reads blocks of lines, one after the other, as numbers of some columns; a gap is NaN.

    labels: the names of all columns, for messages. used: the places of those that are read. row: that of the next line.
    """

    def __init__(self, labels: tuple[str, ...], used: list[int], delimiter: str, first_row: int) -> None:
        self._labels = labels
        self._used = used
        self._delimiter = delimiter
        self.row = first_row
        # the decimal mark, once one was seen: of a file with commas between its cells it is the point
        self._mark = "." if delimiter in ", " else ""
        mark = b"\t" if delimiter == " " else delimiter.encode()
        self._skeleton = mark * (len(labels) - 1) + b"\n"
        self._no_skeleton = bytes(set(_BYTES) - set(mark + b"\n"))
        self._harmless = _NUMERIC + mark + b"\n"
        # a whole cell in quotes, with neither quotes nor marks inside
        self._in_quotes = re.compile(rb'(?<![^%b\n])"([^"%b\n]*)"(?=[%b\n])' % (mark, mark, mark))

    def read(self, block: bytes) -> tuple[Rows, Array]:
        """Row numbers in the file and the values (rows × used) of a block. RecordingError names a broken cell."""
        count = block.count(b"\n")
        values = self._quickly(block, count)
        if values is None:
            rows, values = self._carefully(block)
        else:
            rows = np.arange(self.row, self.row + count, dtype=np.int64)
        self.row += count
        there = ~np.isnan(values).all(axis=1)
        return (rows, values) if there.all() else (rows[there], values[there])

    def _quickly(self, block: bytes, count: int) -> Array | None:
        """The values, if every row has its cells and every cell is a number or a gap; else None."""
        mark = self._mark
        if b'"' in block and self._delimiter != " ":
            block = self._in_quotes.sub(rb"\1", block)
        if mark != ".":
            marks = [sign for sign in (",", ".") if sign.encode() in block]
            if len({mark, *marks} - {""}) > 1:
                return None
            mark = mark or "".join(marks)
            block = block.replace(b",", b".")
        if block.translate(None, self._harmless).lower().replace(b"nan", b""):
            return None
        delimiter = self._delimiter.encode()
        if delimiter == b" ":
            delimiter, block = b"\t", b"\n".join(b"\t".join(line.split()) for line in block.split(b"\n"))
        if block.translate(None, self._no_skeleton) != self._skeleton * count:
            return None
        values = self._loaded(block, delimiter)
        if values is None:
            values = self._loaded(_filled(block, delimiter), delimiter)
        if values is not None:
            self._mark = mark
        return values

    def _loaded(self, block: bytes, delimiter: bytes) -> Array | None:
        try:
            values = np.loadtxt(
                io.BytesIO(block),
                delimiter=delimiter.decode(),
                usecols=self._used,
                comments=None,
                ndmin=2,
                encoding="latin1",
            )
        except ValueError:
            return None
        return None if np.isinf(values).any() else values

    def _carefully(self, block: bytes) -> tuple[Rows, Array]:
        rows, values = [], []
        for row, raw in enumerate(block.split(b"\n")[:-1], start=self.row):
            line = text_of(raw).strip(" ")
            if not line.strip(BLANKS) or line.startswith("#"):
                continue
            rows.append(row)
            values.append(self._line(row, line))
        return np.array(rows, dtype=np.int64), np.array(values, dtype=float).reshape(len(rows), len(self._used))

    def _line(self, row: int, line: str) -> list[float]:
        texts = cells_of_row(row, line, self._delimiter)
        # older programs end rows with a tab, or part the names by tabs and the numbers by blanks
        if self._delimiter == "\t" and len(texts) == 1:
            texts = cells_of_row(row, line, " ")
        elif self._delimiter == "\t" and len(texts) == len(self._labels) + 1 and not texts[-1]:
            texts.pop()
        if len(texts) != len(self._labels):
            cell = "cell" if len(texts) == 1 else "cells"
            raise RecordingError(f"row {row} has {len(texts)} {cell}; the header names {len(self._labels)} columns")
        return [self._number(row, self._labels[i], texts[i]) for i in self._used]

    def _number(self, row: int, label: str, text: str) -> float:
        if GAP.fullmatch(text):
            return math.nan
        if not self._mark and ("," in text or "." in text):
            self._mark = "," if "," in text else "."
        plain = text.translate(_SWAPPED) if self._mark == "," else text
        value = float(plain) if NUMBER.fullmatch(plain) else math.inf
        if math.isfinite(value):
            return value
        where = f"row {row}, column {shown(label)}: {shown(text)}"
        if NUMBER.fullmatch(plain):
            raise RecordingError(f"{where} is too large for a number")
        hint = ""
        if self._delimiter == "," and NUMBER.fullmatch(text.translate(_SWAPPED)):
            hint = "; with decimal commas the cells must be apart by ; or a tab"
        elif self._mark and NUMBER.fullmatch(plain.translate(_SWAPPED)):
            hint = f"; the numbers before it have a decimal {'comma' if self._mark == ',' else 'point'}"
        raise RecordingError(f"{where} is no number{hint}")


def _filled(block: bytes, delimiter: bytes) -> bytes:
    """`block` with nan in its empty cells."""
    between = delimiter + b"nan" + delimiter
    text = b"\n" + block
    # of three marks in a row the first pass sees the first two
    text = text.replace(delimiter * 2, between).replace(delimiter * 2, between)
    text = text.replace(b"\n" + delimiter, b"\nnan" + delimiter).replace(delimiter + b"\n", delimiter + b"nan\n")
    return text[1:]
