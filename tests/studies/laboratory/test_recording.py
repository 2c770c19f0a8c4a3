"""Recordings: the public ones read right, every spelling of a table is the same table, a broken cell is named."""

import gzip
import json
import os
import random
import re
import tomllib
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.studies.files.errors import RecordingError
from hillobs.studies.files.quote import ranges
from hillobs.studies.laboratory import lines, samples
from hillobs.studies.laboratory.columns import COLUMNS, OPENSIM, choose, name_and_unit
from hillobs.studies.laboratory.mapping import read_mapping
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.laboratory.units import SI, UNITS
from places import CORPUS, DATA, RECORDINGS

REFUSED = CORPUS / "recordings"
SHIPPED = RECORDINGS / "dgf_smooth_noisy.csv.gz"
EXCERPTS = ("dgf_smooth_excerpt.csv", "dgf_random_excerpt.sto", "millard_steps_excerpt.csv.gz")
# distance between the origins in all of them
C = 0.62

HEAD = "time,position,force_1,force_2"
ROWS = "\n0,0.31,100,200\n0.001,0.32,101,201.5\n0.002,0.33,102.25,-1e-3\n"
TABLE = HEAD + ROWS


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("recordings")


def reading(
    folder: Path, text: str | bytes, name: str = "file.csv", mapping: dict[str, str] | None = None
) -> Recording:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_recording(path, mapping)


def refusal(folder: Path, text: str | bytes, name: str = "file.csv", mapping: dict[str, str] | None = None) -> str:
    with pytest.raises(RecordingError) as caught:
        reading(folder, text, name, mapping)
    sentence = str(caught.value)
    assert sentence.startswith(str(folder / name))
    return sentence.removeprefix(f"{folder / name}: ")


def numbers(recording: Recording) -> np.ndarray:
    inputs = (recording.time, recording.position, recording.force_1, recording.force_2)
    return np.stack([*inputs, *recording.true.values()], axis=1)


@pytest.mark.parametrize("name", EXCERPTS)
def test_public_recordings_read_right(name: str) -> None:
    found = read_recording(DATA / name)
    true = found.true
    assert len(found) == 101
    assert found.time.dtype == np.float64
    assert set(true) == set(COLUMNS) - {"time", "position", "force_1", "force_2"} - {
        f"{key}_measured" for key in ("position", "force_1", "force_2")
    }
    np.testing.assert_allclose(found.time, np.arange(101) / 10, atol=1e-12)
    np.testing.assert_allclose(true["tendon_length_1"] + true["fibre_length_1"], found.position, atol=2e-9)
    np.testing.assert_allclose(true["tendon_length_2"] + true["fibre_length_2"], C - found.position, atol=2e-9)
    # mass·acceleration = force_2 − force_1 + disturbance
    push = found.force_2 - found.force_1 + true["disturbance"]
    np.testing.assert_allclose(20 * true["acceleration"], push, atol=2e-6)
    assert found.rows[0] == (8 if name.endswith(".sto") else 2)
    assert found.notes() == []


def test_measured_columns_are_the_inputs_and_the_plain_ones_the_truth() -> None:
    found = read_recording(SHIPPED)
    assert (len(found), found.source) == (2001, SHIPPED.name)
    for name, sd in (("position", 1e-4), ("force_1", 5.0), ("force_2", 5.0)):
        noise = getattr(found, name) - found.true[name]
        assert np.std(noise) == pytest.approx(sd, rel=0.06)
    assert not [name for name in found.true if "measured" in name]
    plain = read_recording(SHIPPED, {"position": "position"})
    assert np.array_equal(plain.position, found.true["position"])
    assert "position" not in plain.true
    assert np.array_equal(plain.force_1, found.force_1)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (TABLE.replace("\n", "\r\n"), "crlf.csv"),
        (TABLE.replace("\n", "\r"), "cr.csv"),
        ("\ufeff" + TABLE, "bom.csv"),
        (TABLE.rstrip("\n"), "no-end.csv"),
        (TABLE + "\n,,,\n ,, ,\n", "blank-rows.csv"),
        (TABLE.replace(",", ";"), "semicolon.csv"),
        (TABLE.replace(",", "\t"), "tab.txt"),
        (TABLE.replace(",", " , "), "blanks.csv"),
        ("\ufeff" + TABLE.replace(",", ";").replace(".", ",").replace("\n", "\r\n"), "excel-german.csv"),
        (TABLE.replace(",", "\t").replace(".", ","), "comma-tab.tsv"),
        (TABLE.replace(",", "  "), "blanks.txt"),
        (re.sub(r"[^,\n]+", r'"\g<0>"', TABLE), "quoted.csv"),
        ("# made by hand\n# units: s,m,N,N\n" + TABLE.replace("\n0.002", "\n# half\n\n0.002"), "comments.csv"),
        (HEAD + "\ns,m,N,N" + ROWS, "units-row.csv"),
        (HEAD + "\n(s),[m],(N),[N]" + ROWS, "units-brackets.csv"),
        (TABLE.replace(HEAD, "Time [s],Position (m), FORCE_1 [N],force 2"), "labels.csv"),
        (TABLE.replace(HEAD, "time_s,position_m,force_1_N,force_2_N"), "suffixes.csv"),
        (TABLE.replace(HEAD, ",".join(OPENSIM[key] for key in HEAD.split(","))), "opensim-names.csv"),
        ("name\nversion=1\nnRows=3\nnColumns=4\ninDegrees=no\nendheader\n" + TABLE.replace(",", "\t"), "one.sto"),
        (
            "inDegrees=yes\nnum=3\nDataType=double\nversion=3\nOpenSimVersion=4.6\nendheader\n\n"
            + TABLE.replace(",", "\t"),
            "two.sto",
        ),
        ("ENDHEADER\n" + TABLE.replace(",", "   "), "blanks.mot"),
        ("endheader\n" + TABLE.replace(",", " \t ").replace("\n", "\t\n"), "ends-in-tab.mot"),
        (f"endheader\n{HEAD.replace(',', chr(9))}{ROWS.replace(',', '  ')}", "blanks-below-tabs.mot"),
        ("endheader\r\n" + TABLE.replace(",", "\t").replace("\n", "\r\n"), "crlf.MOT"),
    ],
)
def test_every_spelling_is_the_same_table(text: str, name: str, folder: Path) -> None:
    assert np.array_equal(numbers(reading(folder, text, name)), numbers(reading(folder, TABLE)))
    packed = gzip.compress(text.encode())
    assert np.array_equal(numbers(reading(folder, packed, name + ".gz")), numbers(reading(folder, TABLE)))


def test_what_pandas_writes_is_read(folder: Path) -> None:
    frame = pd.DataFrame({"time": np.arange(4) / 3, "position": [0.1, np.nan, 0.3, 1 / 3], "force_1": [1, 2, 3, 4]})
    frame["force_2"] = [5e-324, 1.7976931348623157e308, -0.0, 1e22]
    frame["trial"] = ["a", "b,c", "", "ü"]
    for options in ({}, {"index": False}, {"sep": ";", "decimal": ","}, {"quoting": 1}, {"na_rep": "NaN"}):
        frame.to_csv(folder / "pandas.csv", **options)
        found = read_recording(folder / "pandas.csv")
        assert np.array_equal(numbers(found), frame[HEAD.split(",")].to_numpy(float), equal_nan=True)
    assert found.notes() == ["position has no value in 1 of 4 rows: 3"]


@pytest.mark.parametrize(
    ("head", "factors"),
    [
        ("time [ms],position [mm],force_1 [kN],force_2 [mN]", (1e-3, 1e-3, 1e3, 1e-3)),
        ("time [µs],position [cm],force_1,force_2 (N)", (1e-6, 1e-2, 1, 1)),
        ("time_min,position_um,force_1_kN,force_2", (60, 1e-6, 1e3, 1)),
        ("# units: ms,mm,N,kN\ntime,position,force_1,force_2", (1e-3, 1e-3, 1, 1e3)),
        ("time,position,force_1,force_2\nms,[mm],,kN", (1e-3, 1e-3, 1, 1e3)),
    ],
)
def test_units_become_SI(head: str, factors: tuple[float, ...], folder: Path) -> None:
    plain, scaled = numbers(reading(folder, TABLE)), numbers(reading(folder, head + ROWS))
    np.testing.assert_allclose(scaled, plain * np.array(factors), rtol=3e-16)
    further = "velocity [mm/s],acceleration [m/s^2],activation_1 [%],disturbance [kN]"
    true = reading(folder, f"{HEAD},{further}\n0,1,2,3,4,5,6,7\n").true
    assert [float(values[0]) for values in true.values()] == [0.004, 5.0, 0.06, 7000.0]


@given(st.sampled_from(sorted(UNITS)), st.floats(-1e290, 1e290).filter(lambda x: x == 0 or abs(x) > 1e-290))
def test_conversion_inverts(name: str, value: float) -> None:
    unit = UNITS[name]
    there = unit.to_SI(np.array([value]))
    np.testing.assert_allclose(unit.from_SI(there), value, rtol=4e-16)
    if unit == SI[unit.quantity]:
        assert there[0] == value


def test_whole_millimetres_are_the_nearest_double(folder: Path) -> None:
    rows = "".join(f"{i},{i},2,3\n" for i in range(1, 1000))
    found = reading(folder, f"time [ms],position [mm],force_1,force_2\n{rows}")
    assert found.position.tolist() == [float(f"{i}e-3") for i in range(1, 1000)]


@given(st.permutations([*HEAD.split(","), "velocity", "note"]))
def test_the_order_of_columns_does_not_matter(folder: Path, order: list[str]) -> None:
    cells = {"time": ["0", "1"], "position": ["2", ""], "force_1": ["4", "5"], "force_2": ["6", "7"]}
    cells |= {"velocity": ["8", "9"], "note": ["10", "11"]}
    rows = [",".join(order), *(",".join(cells[name][row] for name in order) for row in (0, 1))]
    found = reading(folder, "\n".join(rows) + "\n")
    want = np.array([[0, 2, 4, 6, 8], [1, np.nan, 5, 7, 9]])
    assert np.array_equal(numbers(found), want, equal_nan=True)


BROKEN = (
    "abc",
    "1_0",
    "0x1p3",
    "inf",
    "-Infinity",
    "1e999",
    "1e",
    "--1",
    "+",
    ".",
    "1 2",
    "١",
    "1.2.3",
    "nann",
    "n",
    "=1",
)


@given(
    st.integers(0, 11),
    st.integers(0, 4),
    st.sampled_from(BROKEN),
    st.sampled_from([(",", "x.csv"), (";", "x.csv"), ("\t", "x.tsv"), ("\t", "x.sto")]),
    st.randoms(use_true_random=False),
)
def test_the_broken_cell_is_named(
    folder: Path, row: int, column: int, broken: str, style: tuple[str, str], chance: random.Random
) -> None:
    names = [*HEAD.split(","), "velocity", "note"]
    order = chance.sample(names, len(names))
    table = [[repr(i + chance.random() / 2) for _ in order] for i in range(12)]
    for line in table:
        line[order.index("note")] = chance.choice(["hello", "1.5", "", "v1 2"])
    table[row][order.index(names[column])] = broken
    mark, name = style
    head = "endheader\n" if name.endswith(".sto") else ""
    text = head + mark.join(order) + "\n" + "".join(mark.join(line) + "\n" for line in table)
    sentence = refusal(folder, text, name)
    first = 3 if head else 2
    assert sentence.startswith(f"row {row + first}, column '{names[column]}': ")
    assert sentence.endswith(("is no number", "is too large for a number"))


@given(st.integers(1, 12), st.lists(st.floats(allow_infinity=False), min_size=36, max_size=36))
def test_a_comment_changes_nothing_but_the_rows(folder: Path, place: int, values: list[float]) -> None:
    text = [HEAD, *(f"{i},{','.join(map(repr, values[3 * i : 3 * i + 3]))}" for i in range(12))]
    plain = reading(folder, "\n".join(text) + "\n")
    careful = reading(folder, "\n".join([*text[:place], "# a remark", *text[place:]]) + "\n")
    assert numbers(plain).tobytes() == numbers(careful).tobytes()
    assert careful.rows.tolist() == [i + 2 + (i + 1 >= place) for i in range(12)]


def test_a_row_of_another_length_is_named(folder: Path) -> None:
    assert refusal(folder, TABLE + "0.003,1,2\n") == "row 5 has 3 cells; the header names 4 columns"
    assert refusal(folder, TABLE + "0.003,1,2,3,4\n") == "row 5 has 5 cells; the header names 4 columns"
    sto = "endheader\n" + TABLE.replace(",", "\t") + "0.003\t\t1\t2\t3\n"
    assert refusal(folder, sto, "x.sto") == "row 6 has 5 cells; the header names 4 columns"
    # as many marks in two rows as two rows should have
    assert refusal(folder, TABLE + "3,1,2\n4,1,2,3,4\n") == "row 5 has 3 cells; the header names 4 columns"


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ("0,1,2,3\n1,1,2,3\n0.5,1,2,3\n", "row 4: time runs backwards, from 1 to 0.5"),
        (
            "0,1,2,3\n0,1,2,4\n",
            "row 3: time 0 is that of row 2, with other data; was time written with too few digits?",
        ),
        ("0,1,2,3\n,1,2,3\n", "row 3 has no time"),
        ("nan,1,2,3\n", "row 2 has no time"),
        ("", "has names of columns but no row of numbers"),
        (",,,\n", "has names of columns but no row of numbers"),
    ],
)
def test_time_that_does_not_rise_is_refused(rows: str, sentence: str, folder: Path) -> None:
    assert refusal(folder, f"{HEAD}\n{rows}") == sentence


def test_repeated_rows_are_left_out_and_gaps_kept(folder: Path) -> None:
    text = HEAD + "\n0,1,2,3\n0,1,2,3\n0,1,2,3\n0.5,,2,nan\n0.5,,2,nan\n2,1,,3\n"
    # blocks that end anywhere, also between a row and its repetition
    for size in (8, 16, 30, 1000):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(lines, "_BLOCK", size)
            found = reading(folder, text)
        assert found.time.tolist() == [0, 0.5, 2]
        assert found.rows.tolist() == [2, 5, 7]
        assert found.repeated.tolist() == [3, 4, 6]
        assert found.notes() == [
            "rows that repeat the one before are left out: 3–4, 6",
            "position has no value in 1 of 3 rows: 5",
            "force_1 has no value in 1 of 3 rows: 7",
            "force_2 has no value in 1 of 3 rows: 5",
        ]


def test_rows_are_told_briefly() -> None:
    assert ranges([1]) == "1"
    assert ranges([1, 2, 3, 5, 7, 8]) == "1–3, 5, 7–8"
    assert ranges(range(0, 40, 2)) == "0, 2, 4, 6, 8 and 15 more"


@pytest.mark.parametrize(
    ("head", "sentence"),
    [
        ("time,positon,force_1,force_2", "there is no column position; the nearest are 'positon'"),
        ("zeit,x,f,g", "there is no column time; there are 'zeit', 'x', 'f', 'g'"),
        ("time,position,force_1,F2", "there is no column force_2; the nearest are 'force_1'"),
        (",,,", "there is no column time; no column has a name"),
        ("1,2,3,4", "row 1 holds numbers where the names of the columns should be"),
        ("time,position,position,force_1", "position is there twice, in columns 2 and 3; say which by a mapping"),
        (
            "time,position [N],force_1,force_2",
            "column 'position [N]': N is the unit of a force; a length is in m, cm, mm, um",
        ),
        (
            "time,position_deg,force_1,force_2",
            "column 'position_deg': deg is the unit of an angle; a length is in m, cm, mm, um",
        ),
        (
            "time [fortnight],position,force_1,force_2",
            "column 'time [fortnight]': unknown unit 'fortnight'; a time is in s, ms, us, min",
        ),
        (
            "# units: s,mm,N,N\ntime,position [m],force_1,force_2",
            "column 'position [m]': its unit is m in one place and mm in another",
        ),
        (
            "# units: s,mm,N,N\ntime,position,force_1,force_2\ns,mm,N,N",
            "row 3 holds units, and so does a comment above it",
        ),
        ("# units: s,mm\ntime,position,force_1,force_2", "the comment on units has 2 for 4 columns"),
        ('time,"position,force_1,force_2', "row 1: a quoted cell does not end where it should"),
    ],
)
def test_wrong_names_and_units_are_sentences(head: str, sentence: str, folder: Path) -> None:
    assert refusal(folder, head + ROWS) == sentence


def test_a_missing_column_says_what_is_there_and_no_novel(folder: Path) -> None:
    sentence = refusal(folder, ",".join(f"c{i}" for i in range(50)) + "\n")
    first = ", ".join(f"'c{i}'" for i in range(8))
    assert sentence == f"there is no column time; there are {first} and 42 more"
    assert len(refusal(folder, "x" * 100_000 + ",\x1b[31mred\n")) < 400


def test_a_simulation_of_ours_is_a_recording_without_units(folder: Path) -> None:
    text = "# units: 1,1,1,1,1\nt,x1,y2,high_gain.x1_hat,y3\n0,2.6,0.1,2.62,0.2\n"
    found = reading(folder, text, mapping={"time": "t", "position": "x1", "force_1": "y2", "force_2": "y3[N]"})
    assert numbers(found).tolist() == [[0, 2.6, 0.1, 0.2]]


def test_a_mapping_names_columns_and_units(folder: Path) -> None:
    text = "clock (ms),block_x,Force (left),Force (right)\n0,310,1,2\n1,320,1,2\n"
    mapping = {
        "time": "clock (ms)",
        "position": "block_x[mm]",
        "force_1": "Force (left)[kN]",
        "force_2": "Force (right)[N]",
    }
    assert numbers(reading(folder, text, mapping=mapping)).tolist() == [[0, 0.31, 1000, 2], [0.001, 0.32, 1000, 2]]
    typed = [f"{name}={column}" for name, column in mapping.items()]
    assert read_mapping(typed) == mapping
    (folder / "map.toml").write_text(
        'time = "clock (ms)"\nposition = { column = "block_x", unit = "mm" }\n'
        'force_1 = { column = "Force (left)", unit = "kN" }\n'
    )
    assert read_mapping([str(folder / "map.toml"), "force_2=Force (right)[N]"]) == mapping
    # a column mapped elsewhere is not also what its own name says
    swapped = reading(folder, TABLE, mapping={"force_1": "force_2", "force_2": "force_1"})
    assert swapped.force_1.tolist() == [200, 201.5, -1e-3]


@pytest.mark.parametrize(
    ("mapping", "sentence"),
    [
        ({"positon": "a"}, "'positon' is no column of a recording; the nearest are position"),
        ({"position": "posn"}, "position is mapped to 'posn', which is not there; the nearest are 'position'"),
        (
            {"position": "velocity"},
            "column 'velocity [m/s]': m/s is the unit of a velocity; a length is in m, cm, mm, um",
        ),
        ({"position": "force_1"}, "there is no column force_1; 'force_1' is mapped to position"),
        ({"force_1": "force_2", "force_2": "force_2"}, "column 'force_2' is mapped to both force_1 and force_2"),
        ({"position": "position[furlong]"}, "column 'position': unknown unit 'furlong'; a length is in m, cm, mm, um"),
        (
            {"position": "velocity [m/s][mm]"},
            "column 'velocity [m/s]': m/s is the unit of a velocity; a length is in m, cm, mm, um",
        ),
        ({"time": "a" * 500}, f"time is mapped to '{'a' * 59}"),
    ],
)
def test_a_wrong_mapping_is_a_sentence(mapping: dict[str, str], sentence: str, folder: Path) -> None:
    assert refusal(folder, f"{HEAD},velocity [m/s]\n0,1,2,3,4\n", mapping=mapping).startswith(sentence)


@pytest.mark.parametrize("text", ["position", "=x", "position=", "nowhere.toml"])
def test_a_mapping_that_is_none_is_a_sentence(text: str) -> None:
    with pytest.raises(RecordingError, match=r"NAME=COLUMN|cannot be read: No such file"):
        read_mapping([text])


def test_a_mapping_file_is_checked(tmp_path: Path) -> None:
    path = tmp_path / "map.toml"
    for content in (
        "position = 3",
        'position = { column = "x", units = "mm" }',
        'position = { unit = "mm" }',
        "[position]",
    ):
        path.write_text(content)
        with pytest.raises(RecordingError, match=r"map\.toml: position must be \"COLUMN\" or"):
            read_mapping([str(path)])
    with pytest.raises(RecordingError, match="'position' is mapped twice, to 'a' and 'b'"):
        read_mapping(["position=a", "position=b"])


def test_names_are_known_in_every_spelling() -> None:
    assert name_and_unit(" Fiber_Length_1 (mm) ") == ("fibre_length_1", "mm")
    assert name_and_unit("/forceset/m2|tendon_force") == ("force_2", "")
    assert name_and_unit("position_min") == ("position_min", "")
    assert name_and_unit("force_1_1") == ("force_1_1", "")
    assert name_and_unit("activation_1 []") == ("activation_1", "1")
    columns = choose(["time", "position_mm", "position_max", "force_1", "force_2"], [""] * 5, {})
    assert [(column.name, column.unit.symbol) for column in columns][1] == ("position", "mm")
    assert (
        choose(["a", "x_mm", "b", "c"], [""] * 4, dict(zip(HEAD.split(","), ["a", "x_mm", "b", "c"], strict=True)))[
            1
        ].unit
        == UNITS["mm"]
    )


@pytest.mark.parametrize(
    ("head", "sentence"),
    [
        ("name\nnRows=3\n", "has no line endheader among its first"),
        ("DataType=Vec3\nendheader\n", "its DataType is 'Vec3'; a recording holds double"),
        ("x\n" * 2000 + "endheader\n", "has no line endheader among its first 1,000"),
    ],
)
def test_a_wrong_sto_header_is_a_sentence(head: str, sentence: str, folder: Path) -> None:
    assert refusal(folder, head + TABLE.replace(",", "\t"), "x.sto").startswith(sentence)
    assert refusal(folder, "endheader\n\n", "x.sto") == "has no row with names of columns after endheader"


def test_an_sto_header_that_lies_is_a_remark(folder: Path) -> None:
    head = "n\nversion=1\nnRows=99999999999\nnColumns=3\nendheader\n"
    found = reading(folder, head + TABLE.replace(",", "\t"), "x.sto")
    assert found.notes() == [
        "the header says nColumns=3, there are 4",
        "the header says nRows=99999999999, there are 3",
    ]
    assert len(found) == 3


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
    found = read_recording(path, progress=done.append)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert numbers(found).tobytes() == values.tobytes()
    assert found.rows.tolist() == list(range(2, len(values) + 2))
    assert (done[-1], done) == (1.0, sorted(done))
    assert len(done) > 20
    # the blocks' numbers, the columns made of them, and a few blocks as text
    assert peak < 2 * (values.nbytes + found.rows.nbytes) + 20 * 50_000


def test_more_numbers_than_memory_should_hold_are_refused_before_they_are_kept(
    long: tuple[Path, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, values = long
    monkeypatch.setattr(lines, "_BLOCK", 50_000)
    # time, three inputs and the row of the file
    least = 5 * len(values)
    monkeypatch.setattr(samples, "_MOST_NUMBERS", least)
    assert len(read_recording(path)) == len(values)
    monkeypatch.setattr(samples, "_MOST_NUMBERS", least // 10)
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


EXPECTED = tomllib.loads((REFUSED / "expected.toml").read_text())


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_the_corpus_is_refused_or_read_as_expected(name: str) -> None:
    path = REFUSED / name
    before = path.read_bytes()
    try:
        found = read_recording(path)
    except RecordingError as error:
        told = str(error).removeprefix(f"{path}: ")
    else:
        told = json.dumps(numbers(found)[-1].tolist())
    assert told == EXPECTED[name]
    assert path.read_bytes() == before


def test_the_corpus_has_no_file_that_nobody_expects() -> None:
    assert {path.name for path in REFUSED.iterdir()} == {*EXPECTED, "expected.toml"}


@given(st.data())
def test_any_damage_is_a_recording_or_one_sentence(folder: Path, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(["dgf_smooth_excerpt.csv", "dgf_random_excerpt.sto"]))
    raw = bytearray(b"\n".join((DATA / name).read_bytes().split(b"\n")[:12]) + b"\n")
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(raw) - 1))
        piece = data.draw(
            st.sampled_from([b"", b"nan", b"1e999", b",", b"\t", b'"', b"\r", b"\n", b"#", b"\0", b"\xff", b";"])
        )
        raw[at : at + data.draw(st.integers(0, 3))] = piece
    path = folder / name
    path.write_bytes(raw)
    told = ""
    try:
        found = read_recording(path)
        assert (np.diff(found.time) > 0).all()
        assert not np.isinf(numbers(found)).any()
    except RecordingError as error:
        told = str(error)
    assert not told or told.startswith(f"{path}: ")
    assert len(told) < 600
    assert path.read_bytes() == bytes(raw)
