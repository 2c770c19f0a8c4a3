"""A recording: position and two tendon forces over time, from CSV or OpenSim's .sto and .mot, in SI."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from ...model.arrays import Array
from ..files.errors import RecordingError, ScenarioError
from ..files.numbers import samples
from ..files.progress import Progress, unseen
from ..files.quote import escaped, ranges, shown, table, text
from .cells import Cells, Rows
from .columns import COLUMNS, Columns, choose
from .header import read_header
from .lines import blocks, text_of
from .samples import MOST_NUMBERS, Samples

_OPENSIM = (".sto", ".mot")
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Recording:
    """Samples in SI, time rising strictly: what an observer is given, and the truth where a file has it.

    time s; measured: position m, force_1 and force_2 N of a pair, or those of a mechanism, by name: float64 (n,), NaN
    where there is a gap. true: further known columns by name. rows: the row of the file each sample comes from,
    counted from 1. source: where they come from. repeated: rows left out because they repeat the row before. remarks:
    what else to know, in sentences. mapping: which columns of the file were named. columns: what there is to know, of a
    pair by default. RecordingError if columns are no arrays of numbers of one length, one is missing, or time does not
    rise.
    """

    source: str
    time: Array
    measured: Mapping[str, Array]
    true: Mapping[str, Array]
    rows: Rows
    repeated: Rows = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    remarks: tuple[str, ...] = ()
    mapping: Mapping[str, str] = field(default_factory=dict)
    columns: Columns = COLUMNS

    def __post_init__(self) -> None:
        try:
            object.__setattr__(self, "source", text("source", self.source))
            given = {"time": self.time, **table("measured", self.measured)}
            if odd := [name for name in (*self.columns.required, *given) if name not in given or not self._is(name)]:
                raise RecordingError(f"measured must be {', '.join(self.columns.required)}; see {shown(odd[0])}")
            columns = {name: samples(name, values, MOST_NUMBERS) for name, values in given.items()}
            true = {name: samples(name, values, MOST_NUMBERS) for name, values in table("true", self.true).items()}
        except ScenarioError as error:
            raise RecordingError(str(error)) from error
        for name, values in {**columns, **true}.items():
            if len(values) != len(columns["time"]):
                raise RecordingError(f"{name} has {len(values):,} values, and time {len(columns['time']):,}")
        if not (np.isfinite(columns["time"]).all() and (np.diff(columns["time"]) > 0).all()):
            raise RecordingError("time must rise strictly from sample to sample")
        if unknown := [name for name in true if name not in self.columns.known]:
            known = ", ".join(self.columns.known)
            raise RecordingError(f"{shown(unknown[0])} is no column of a recording; there are {known}")
        object.__setattr__(self, "true", true)
        object.__setattr__(self, "time", columns.pop("time"))
        object.__setattr__(self, "measured", {name: columns[name] for name in self.columns.required})

    def __repr__(self) -> str:
        """What it is of, and how long."""
        seconds = f", {self.time[-1] - self.time[0]:g} s" if len(self) else ""
        return f"Recording({self.source}: {len(self):,} samples{seconds}; {', '.join(self.measured)})"

    def _is(self, name: str) -> bool:
        return name in ("time", *self.columns.required)

    def __getitem__(self, name: str) -> Array:
        """What was measured."""
        return self.measured[name]

    def part(self, which: slice) -> Recording:
        """Some of its samples."""
        measured, true = ({name: values[which] for name, values in of.items()} for of in (self.measured, self.true))
        return replace(self, time=self.time[which], measured=measured, true=true, rows=self.rows[which])

    def remeasured(self, **measured: Array) -> Recording:
        """The same with other measurements."""
        return replace(self, measured={**self.measured, **measured})

    def __len__(self) -> int:
        return len(self.time)

    def notes(self) -> list[str]:
        """What a user should know: gaps and rows left out, by their numbers, and the remarks."""
        notes = list(self.remarks)
        if len(self.repeated):
            notes.append(f"rows that repeat the one before are left out: {ranges(self.repeated)}")
        for name, values in self.measured.items():
            gaps = self.rows[np.isnan(values)]
            if len(gaps):
                notes.append(f"{name} has no value in {len(gaps):,} of {len(self):,} rows: {ranges(gaps)}")
        return notes


def read_recording(
    path: str | Path,
    mapping: Mapping[str, str] | None = None,
    progress: Progress | None = None,
    known: Columns = COLUMNS,
) -> Recording:
    """The recording in the file `path`: CSV, .sto, .mot, each also gzipped; in SI, whatever its units.

    mapping: name → column of the file, or `column[unit]`. progress: given the part of the file that has been read.
    known: what columns may be called, those of a pair by default.
    RecordingError names the file and row and column, or says which column is missing and what is there; also if there
    are more numbers than memory should hold.

    >>> run = hillobs.read_recording("run.csv", {"position": "block x[mm]"})
    >>> run
    Recording(run.csv: 2,001 samples, 10 s; position, force_1, force_2)
    >>> print(f"{run['position'][0]:.3f} m")
    0.310 m
    """
    if not isinstance(path, str | Path):
        raise RecordingError(f"a recording is a file's name or one that was read, not {shown(path)}")
    given = table("mapping", mapping or {})
    columns = {name: text(f"the column of {name} in mapping", column) for name, column in given.items()}
    try:
        return _read(Path(path), columns, progress or unseen, known)
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from error


def _read(path: Path, mapping: Mapping[str, str], progress: Progress, columns_known: Columns) -> Recording:
    source = blocks(path, progress)
    first = next(source, None)
    if first is None:
        raise RecordingError("is empty")
    header = read_header(text_of(first).split("\n")[:-1], _is_opensim(path))
    columns = choose(header.labels, header.units, mapping, columns_known, header.in_degrees)
    reader = Cells(header.labels, [column.index for column in columns], header.delimiter, header.lines + 1)
    rest = first.split(b"\n", header.lines)[-1]

    samples = Samples()
    for block in itertools.chain([rest] if rest else [], source):
        samples.add(*reader.read(block))
    if not len(samples):
        raise RecordingError("has names of columns but no row of numbers")
    rows, repeated, remarks = samples.rows, samples.repeated, header.remarks
    if header.promised not in (None, len(rows) + len(repeated)):
        remarks += (f"the header says nRows={header.promised}, there are {len(rows) + len(repeated)}",)
    known = {column.name: column.unit.to_SI(samples.column(i)) for i, column in enumerate(columns)}
    inputs = taken_inputs(known, mapping, columns_known.required)
    return Recording(
        escaped(path.name),
        known.pop("time"),
        inputs,
        true=known,
        rows=rows,
        repeated=repeated,
        remarks=remarks,
        mapping=dict(mapping),
        columns=columns_known,
    )


def taken_inputs(known: dict[str, T], mapping: Mapping[str, str], required: tuple[str, ...]) -> dict[str, T]:
    """What observers are given, taken out of `known`: a measured column before the plain one, unless that is mapped."""
    inputs = {}
    for name in required:
        measured = f"{name}_measured"
        plain_asked = name in mapping and measured not in mapping
        inputs[name] = known.pop(name if plain_asked or measured not in known else measured)
        known.pop(measured, None)
    return inputs


def _is_opensim(path: Path) -> bool:
    name = path.name.lower().removesuffix(".gz")
    return name.endswith(_OPENSIM)
