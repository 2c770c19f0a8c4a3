"""A recording: position and two tendon forces over time, from CSV or OpenSim's .sto and .mot, in SI."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...model.arrays import Array
from ..files.errors import RecordingError
from ..files.progress import Progress, unseen
from ..files.quote import ranges
from .cells import Cells, Rows
from .columns import INPUTS, Column, choose
from .header import read_header
from .lines import blocks, text_of
from .samples import Samples

_OPENSIM = (".sto", ".mot")
_CHUNK = 65_536
# an hour at 1 kHz with all known columns is 75 million numbers; these are 2 GB
_MOST_NUMBERS = 250_000_000


@dataclass(frozen=True, eq=False)
class Recording:
    """Samples in SI, time rising strictly: what an observer is given, and the truth where a file has it.

    time s, position m, force_1 and force_2 N: float64 (n,), NaN where there is a gap. true: further known columns by
    name. rows: the row of the file each sample comes from, counted from 1. repeated: rows left out because they
    repeat the row before. remarks: what else to know, in sentences.
    """

    source: str
    time: Array
    position: Array
    force_1: Array
    force_2: Array
    true: Mapping[str, Array]
    rows: Rows
    repeated: Rows = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    remarks: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.time)

    def notes(self) -> list[str]:
        """What a user should know: gaps and rows left out, by their numbers, and the remarks."""
        found = list(self.remarks)
        if len(self.repeated):
            found.append(f"rows that repeat the one before are left out: {ranges(self.repeated)}")
        for name in INPUTS:
            gaps = self.rows[np.isnan(getattr(self, name))]
            if len(gaps):
                found.append(f"{name} has no value in {len(gaps):,} of {len(self):,} rows: {ranges(gaps)}")
        return found


def read_recording(path: str | Path, mapping: Mapping[str, str] | None = None) -> Recording:
    """A whole recording. RecordingError as in `read_chunks`, or if it has more numbers than memory should hold."""
    chunks, numbers = [], 0
    for chunk in read_chunks(path, mapping):
        chunks.append(chunk)
        numbers += len(chunk) * (5 + len(chunk.true))
        if numbers > _MOST_NUMBERS:
            raise RecordingError(f"{path}: holds more than {_MOST_NUMBERS:,} numbers; read it in chunks")
    return joined(chunks)


def read_chunks(
    path: str | Path,
    mapping: Mapping[str, str] | None = None,
    rows_per_chunk: int = _CHUNK,
    progress: Progress = unseen,
) -> Iterator[Recording]:
    """A recording of any length in pieces of `rows_per_chunk` samples; the last one may be shorter.

    path: CSV, .sto, .mot, each also gzipped. mapping: name → column of the file, or `column[unit]`.
    progress: given the part of the file that has been read.
    RecordingError names the file and row and column, or says which column is missing and what is there.
    """
    try:
        yield from _chunks(Path(path), mapping or {}, rows_per_chunk, progress)
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from error


def joined(chunks: Sequence[Recording]) -> Recording:
    """Chunks that follow each other as one recording."""

    def all_of(name: str) -> Array:
        return np.concatenate([getattr(chunk, name) for chunk in chunks])

    return Recording(
        source=chunks[0].source,
        **{name: all_of(name) for name in ("time", *INPUTS)},
        true={name: np.concatenate([chunk.true[name] for chunk in chunks]) for name in chunks[0].true},
        rows=np.concatenate([chunk.rows for chunk in chunks]),
        repeated=np.concatenate([chunk.repeated for chunk in chunks]),
        remarks=tuple(itertools.chain.from_iterable(chunk.remarks for chunk in chunks)),
    )


def _chunks(path: Path, mapping: Mapping[str, str], size: int, progress: Progress) -> Iterator[Recording]:
    source = blocks(path, progress)
    first = next(source, None)
    if first is None:
        raise RecordingError("is empty")
    header = read_header(text_of(first).split("\n")[:-1], _is_opensim(path))
    columns = choose(header.labels, header.units, mapping)
    reader = Cells(header.labels, [column.index for column in columns], header.delimiter, header.lines + 1)
    rest = first.split(b"\n", header.lines)[-1]

    samples, count, remarks = Samples(size), 0, header.remarks
    for block in itertools.chain([rest] if rest else [], source):
        samples.add(*reader.read(block))
        while samples.more_than_full:
            count += size
            yield _recording(path.name, samples, columns, mapping, remarks)
            remarks = ()
    count += len(samples)
    if not count:
        raise RecordingError("has names of columns but no row of numbers")
    if header.promised not in (None, count + samples.left_out):
        remarks += (f"the header says nRows={header.promised}, there are {count + samples.left_out}",)
    yield _recording(path.name, samples, columns, mapping, remarks)


def _recording(
    source: str, samples: Samples, columns: Sequence[Column], mapping: Mapping[str, str], remarks: tuple[str, ...]
) -> Recording:
    """The next samples, in SI; a measured column is an input before the plain one, unless a mapping names that."""
    rows, values, repeated = samples.take()
    known = {column.name: np.ascontiguousarray(column.unit.to_SI(values[:, i])) for i, column in enumerate(columns)}
    inputs = {}
    for name in INPUTS:
        measured = f"{name}_measured"
        plain_asked = name in mapping and measured not in mapping
        inputs[name] = known.pop(name if plain_asked or measured not in known else measured)
        known.pop(measured, None)
    return Recording(source, known.pop("time"), **inputs, true=known, rows=rows, repeated=repeated, remarks=remarks)


def _is_opensim(path: Path) -> bool:
    name = path.name.lower().removesuffix(".gz")
    return name.endswith(_OPENSIM)
