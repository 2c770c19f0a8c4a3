"""Long files are read in blocks, with progress and in little memory; bombs and what is no file are refused."""

import gzip
import os
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.studies.files.errors import RecordingError
from hillobs.studies.laboratory import lines, samples
from hillobs.studies.laboratory.recording import read_recording
from written_recording import HEAD, TABLE, numbers, reading, refusal


@pytest.fixture(scope="module")
def long(folder: Path) -> tuple[Path, np.ndarray]:
    """A file of 40,000 rows, and its numbers."""
    n = 40_000
    values = np.column_stack([np.arange(n) / 1000, np.random.default_rng(4).standard_normal((n, 3)).round(6)])
    (folder / "long.csv").write_text(HEAD + "\n" + "".join(f"{','.join(map(repr, row))}\n" for row in values.tolist()))
    return folder / "long.csv", values


def test_reading_a_long_file_tells_its_progress_and_takes_little_more_than_its_numbers(
    long: tuple[Path, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, values = long
    monkeypatch.setattr(lines, "_BLOCK", 50_000)
    done: list[float] = []
    tracemalloc.start()
    recording = read_recording(path, progress=done.append)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert numbers(recording).tobytes() == values.tobytes()
    assert recording.rows.tolist() == list(range(2, len(values) + 2))
    assert (done[-1], done) == (1.0, sorted(done))
    assert len(done) > 20
    # the blocks' numbers, the columns made of them, and a few blocks as text
    assert peak < 2 * (values.nbytes + recording.rows.nbytes) + 20 * 50_000


def test_more_numbers_than_memory_should_hold_are_refused_before_they_are_kept(
    long: tuple[Path, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, values = long
    monkeypatch.setattr(lines, "_BLOCK", 50_000)
    # time, three inputs and the row of the file
    least = 5 * len(values)
    monkeypatch.setattr(samples, "MOST_NUMBERS", least)
    assert len(read_recording(path)) == len(values)
    monkeypatch.setattr(samples, "MOST_NUMBERS", least // 10)
    tracemalloc.start()
    with pytest.raises(RecordingError, match=r"long\.csv: holds more than 20,000 numbers; cut it into parts"):
        read_recording(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < values.nbytes


@given(st.integers(40, 200), st.sampled_from(["\n", "\r\n", "\r"]))
def test_where_blocks_end_does_not_matter(folder: Path, size: int, end: str) -> None:
    text = HEAD + "".join(f"{end}{i},{i / 3},{'' if i % 7 == 0 else 2},{i % 5}" for i in range(60))
    whole = reading(folder, text)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lines, "_BLOCK", size)
        pieces = reading(folder, text)
    assert numbers(pieces).tobytes() == numbers(whole).tobytes()
    assert pieces.rows.tolist() == whole.rows.tolist() == list(range(2, 62))


def bombs() -> Iterator[tuple[str, bytes, str]]:
    remark = b"# " + b"a" * 60_000 + b"\n"
    yield "ratio.csv.gz", gzip.compress(TABLE.encode() + remark * 400), "unfolds to more than 200 times its size"
    yield "line.csv", HEAD.encode() + b"," * 3_000_000, "row 1 is longer than 1,000,000 bytes"
    yield "line.csv.gz", gzip.compress(TABLE.encode() + b"1" * 3_000_000), "row 5 is longer than 1,000,000 bytes"
    yield "columns.csv", HEAD.encode() + b",a" * 20_000 + b"\n", "row 1 has more than 10,000 columns"
    yield "zeros.csv", TABLE.encode() + b"\0" * 100, "holds zero bytes"
    yield "wide.csv", TABLE.encode("utf-16"), "is UTF-16"
    whole = gzip.compress(TABLE.encode() * 50)
    yield "cut.csv.gz", whole[: len(whole) // 2], "the gzip file ends early"
    yield "bits.csv.gz", whole[:20] + b"\xff" * 10 + whole[30:], "the gzip file is damaged"


@pytest.mark.parametrize(("name", "content", "sentence"), list(bombs()), ids=[name for name, _, _ in bombs()])
def test_bombs_are_refused_before_they_take_memory(name: str, content: bytes, sentence: str, folder: Path) -> None:
    tracemalloc.start()
    assert sentence in refusal(folder, content, name)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 25_000_000


def test_only_regular_files_are_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    for path, cause in (
        (tmp_path / "pipe.csv", "no regular file"),
        (tmp_path, "directory"),
        ("/dev/zero", "no regular"),
    ):
        with pytest.raises(RecordingError, match=f"cannot be read: .*{cause}"):
            read_recording(path)
    with pytest.raises(RecordingError, match="No such file"):
        read_recording(tmp_path / "nowhere.csv")


def test_a_file_larger_than_the_limit_is_refused(folder: Path) -> None:
    with open(folder / "sparse.csv", "wb") as file:
        file.truncate(17_000_000_000)
    with pytest.raises(RecordingError, match="larger than 16,000,000,000 bytes"):
        read_recording(folder / "sparse.csv")
