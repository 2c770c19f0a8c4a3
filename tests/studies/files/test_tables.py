"""What is written reads back bit for bit, whole or not at all."""

import io
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.studies.files import tables as write_table
from hillobs.studies.files.errors import ResultError
from hillobs.studies.files.tables import Series, write_csv, write_sto
from hillobs.studies.files.writing import write_pieces
from hillobs.studies.laboratory.columns import COLUMNS
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.laboratory.units import SI
from places import DATA

NAMES = ("time", "position", "force_1", "force_2", "activation_2")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("tables")


def series(recording: Recording) -> list[Series]:
    """All columns of a recording, under our names."""
    inputs = {"time": recording.time, **recording.measured}
    return [
        Series(name, SI[COLUMNS.known[name]].symbol, values) for name, values in {**inputs, **recording.true}.items()
    ]


@given(st.lists(st.tuples(*[st.floats(allow_infinity=False)] * 4), min_size=1, max_size=20))
def test_every_finite_number_and_gap_reads_back_bit_for_bit(folder: Path, rows: list[tuple[float, ...]]) -> None:
    table = np.column_stack([np.arange(len(rows)) / 3, np.array(rows)])
    columns = [
        Series(name, SI[COLUMNS.known[name]].symbol, values) for name, values in zip(NAMES, table.T, strict=True)
    ]
    write_csv(folder / "x.csv", columns)
    write_sto(folder / "x.sto", "title", columns)
    for name in ("x.csv", "x.sto"):
        back = read_recording(folder / name)
        for wrote in columns:
            values = (
                back.true[wrote.name] if wrote.name in back.true else {"time": back.time, **back.measured}[wrote.name]
            )
            assert np.array_equal(
                values.view(np.int64)[~np.isnan(values)], wrote.values[~np.isnan(values)].view(np.int64)
            )
            assert np.array_equal(np.isnan(values), np.isnan(wrote.values))


@pytest.mark.parametrize("name", ["dgf_smooth_excerpt.csv", "dgf_random_excerpt.sto", "millard_steps_excerpt.csv.gz"])
def test_public_recordings_go_round_in_both_formats(name: str, tmp_path: Path) -> None:
    found = series(read_recording(DATA / name))
    write_csv(tmp_path / "x.csv", found)
    write_sto(tmp_path / "x.sto", "x", [Series(COLUMNS.opensim[one.name], one.unit, one.values) for one in found])
    for back in (tmp_path / "x.csv", tmp_path / "x.sto"):
        again = series(read_recording(back))
        assert [(one.name, one.unit, one.values.tobytes()) for one in again] == [
            (one.name, one.unit, one.values.tobytes()) for one in found
        ]
    # nine digits are the shortest text of themselves
    if name.endswith(".csv"):
        wrote = np.genfromtxt(tmp_path / "x.csv", delimiter=",", skip_header=1)
        assert np.array_equal(np.sort(wrote), np.sort(np.genfromtxt(DATA / name, delimiter=",", skip_header=1)))


def test_the_header_is_what_opensim_expects(tmp_path: Path) -> None:
    columns = [
        Series("time", "s", np.array([0.0, 0.5])),
        Series("/forceset/m1/activation", "1", np.array([0.25, np.nan])),
    ]
    write_sto(tmp_path / "x.sto", "two\nlines", columns)
    assert (tmp_path / "x.sto").read_bytes() == (
        b"two lines\nversion=1\nnRows=2\nnColumns=2\ninDegrees=no\nendheader\n"
        b"time\t/forceset/m1/activation\n0\t0.25\n0.5\tnan\n"
    )


def test_a_csv_names_its_units_and_pandas_reads_it(tmp_path: Path) -> None:
    columns = [Series("time", "s", np.array([0.0, 0.5])), Series("a_1, left", "1", np.array([1e300, np.nan]))]
    write_csv(tmp_path / "x.csv", columns)
    assert (tmp_path / "x.csv").read_text() == 'time [s],"a_1, left"\n0,1e+300\n0.5,\n'
    frame = pd.read_csv(io.StringIO((tmp_path / "x.csv").read_text()))
    assert frame["a_1, left"].isna().tolist() == [False, True]


def test_many_rows_are_written_in_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    columns = [Series("time", "s", np.arange(50.0)), Series("b", "N", np.arange(50.0) ** 2)]
    write_csv(tmp_path / "one.csv", columns)
    monkeypatch.setattr(write_table, "_PIECE", 7)
    write_csv(tmp_path / "many.csv", columns)
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "many.csv").read_bytes()


def test_pieces_that_end_in_an_error_leave_nothing(tmp_path: Path) -> None:
    def broken() -> Iterator[bytes]:
        yield b"first"
        raise RuntimeError("the second is not to be had")

    (tmp_path / "x").write_bytes(b"old")
    with pytest.raises(RuntimeError, match="second"):
        write_pieces(tmp_path / "x", broken())
    assert (tmp_path / "x").read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["x"]


def test_a_table_that_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(ResultError, match=r"x\.csv cannot be written: No such file"):
        write_csv(tmp_path / "nowhere" / "x.csv", [Series("time", "s", np.zeros(1))])
