"""Samples out of the lines of a stream: CSV with the header of a recording, or an object of JSON on each line."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import NamedTuple, Protocol

import numpy as np

from ..files.errors import RecordingError
from ..files.quote import shown
from ..laboratory.cells import Cells
from ..laboratory.columns import Column, Columns, choose
from ..laboratory.header import read_header
from ..laboratory.lines import LONGEST_LINE, text_of
from ..laboratory.recording import taken_inputs
from .samples import plain_number

_MARK = b"\xef\xbb\xbf"
_JSON = b"{"


class Sample(NamedTuple):
    """What is measured, in SI, in the order of the columns; NaN or None where there is no value, None for no time."""

    time: float | None
    values: list[float | None]


class _Form(Protocol):
    def sample(self, line: bytes, row: int) -> Sample | None: ...


class Lines:
    """Reads a stream line by line.

    columns: what may be measured. mapping: name → column, as for recordings. timeless: time may be missing.
    """

    def __init__(self, columns: Columns, mapping: Mapping[str, str], timeless: bool) -> None:
        self._chosen = _Choice(columns, mapping, timeless)
        self._head: list[bytes] = []
        self._form: _Form | None = None
        self.row = 0

    @property
    def begun(self) -> bool:
        """Whether it is known what the columns are: until then what is wrong is wrong with the whole stream."""
        return self._form is not None

    @property
    def is_json(self) -> bool:
        """Whether the lines are JSON."""
        return isinstance(self._form, _Objects)

    def sample(self, line: bytes) -> Sample | None:
        """The sample on the next line, if there is one. RecordingError names the row and says what is wrong with it."""
        self.row += 1
        line = line.rstrip(b"\r\n")
        if self.row == 1:
            line = line.removeprefix(_MARK)
        if len(line) > LONGEST_LINE:
            raise RecordingError(f"row {self.row} is longer than {LONGEST_LINE:,} bytes")
        if b"\0" in line:
            raise RecordingError(f"row {self.row} holds zero bytes: it is no text")
        if self._form is None:
            return self._first(line)
        return self._form.sample(line, self.row)

    def _first(self, line: bytes) -> Sample | None:
        """A line of the head; the one after the names is either one of units or the first sample."""
        if not self._head and line.lstrip().startswith(_JSON):
            objects = _Objects(self._chosen)
            try:
                return objects.sample(line, self.row)
            finally:
                # what the columns are is known, even if a value is none
                self._form = objects if objects.columns else None
        named = any(text.strip() and not text.lstrip().startswith(b"#") for text in self._head)
        self._head.append(line)
        if not named:
            return None
        header = read_header([text_of(text) for text in self._head], opensim=False)
        columns = self._chosen.of(header.labels, header.units)
        self._form = _Table(Cells(header.labels, [c.index for c in columns.all], header.delimiter, self.row), columns)
        return None if header.lines == self.row else self._form.sample(line, self.row)


class _Chosen:
    """The columns that samples are made of."""

    def __init__(self, time: Column | None, inputs: list[Column]) -> None:
        self.time, self.inputs = time, inputs
        self.all = [*([time] if time else []), *inputs]

    def sample(self, values: list[float | None]) -> Sample:
        """The values of all, in the units that they are written in."""
        in_SI = [
            None if value is None else float(column.unit.to_SI(np.array([value]))[0])
            for column, value in zip(self.all, values, strict=True)
        ]
        if self.time is None:
            return Sample(None, in_SI)
        return Sample(in_SI[0], in_SI[1:])


class _Choice:
    def __init__(self, columns: Columns, mapping: Mapping[str, str], timeless: bool) -> None:
        self._columns, self._mapping, self._timeless = columns, mapping, timeless

    def of(self, labels: tuple[str, ...], units: tuple[str, ...]) -> _Chosen:
        """RecordingError if a column is missing, or a unit wrong."""
        columns = choose(labels, units, self._mapping, self._columns, timeless=self._timeless)
        known = {column.name: column for column in columns}
        inputs = taken_inputs(known, self._mapping, self._columns.required)
        return _Chosen(known.get("time"), list(inputs.values()))


class _Table:
    def __init__(self, cells: Cells, columns: _Chosen) -> None:
        self._cells, self._columns = cells, columns

    def sample(self, line: bytes, row: int) -> Sample | None:
        # of lines before it some were refused before they came here
        self._cells.row = row
        _, values = self._cells.read(line + b"\n")
        return self._columns.sample(values[0].tolist()) if len(values) else None


class _Objects:
    def __init__(self, choice: _Choice) -> None:
        self._choice = choice
        self.columns: _Chosen | None = None

    def sample(self, line: bytes, row: int) -> Sample | None:
        if not line.strip():
            return None
        try:
            told = json.loads(text_of(line))
        except (ValueError, RecursionError) as error:
            raise RecordingError(f"row {row} is no JSON") from error
        if not isinstance(told, dict):
            raise RecordingError(f'row {row} is no object such as {{"time": 0.1}}, but {shown(told)}')
        if self.columns is None:
            self.columns = self._choice.of(tuple(told), ("",) * len(told))
        named = [(column.label, told.get(column.label)) for column in self.columns.all]
        try:
            return self.columns.sample(
                [None if value is None else plain_number(label, value) for label, value in named]
            )
        except RecordingError as error:
            raise RecordingError(f"row {row}: {error}") from error
