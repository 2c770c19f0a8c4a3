"""Every spelling of a table is the same table: marks, line ends, quotes, comments, headers, the order of columns."""

import gzip
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.studies.laboratory.columns import COLUMNS
from hillobs.studies.laboratory.recording import read_recording
from written_recording import HEAD, ROWS, TABLE, numbers, reading


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
        (TABLE.replace(HEAD, ",".join(COLUMNS.opensim[key] for key in HEAD.split(","))), "opensim-names.csv"),
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
        recording = read_recording(folder / "pandas.csv")
        assert np.array_equal(numbers(recording), frame[HEAD.split(",")].to_numpy(float), equal_nan=True)
    assert recording.notes() == ["position has no value in 1 of 4 rows: 3"]


@given(st.permutations([*HEAD.split(","), "velocity", "note"]))
def test_the_order_of_columns_does_not_matter(folder: Path, order: list[str]) -> None:
    cells = {"time": ["0", "1"], "position": ["2", ""], "force_1": ["4", "5"], "force_2": ["6", "7"]}
    cells |= {"velocity": ["8", "9"], "note": ["10", "11"]}
    rows = [",".join(order), *(",".join(cells[name][row] for name in order) for row in (0, 1))]
    recording = reading(folder, "\n".join(rows) + "\n")
    expected = np.array([[0, 2, 4, 6, 8], [1, np.nan, 5, 7, 9]])
    assert np.array_equal(numbers(recording), expected, equal_nan=True)


@given(st.integers(1, 12), st.lists(st.floats(allow_infinity=False), min_size=36, max_size=36))
def test_a_comment_changes_nothing_but_the_rows(folder: Path, place: int, values: list[float]) -> None:
    text = [HEAD, *(f"{i},{','.join(map(repr, values[3 * i : 3 * i + 3]))}" for i in range(12))]
    plain = reading(folder, "\n".join(text) + "\n")
    careful = reading(folder, "\n".join([*text[:place], "# a remark", *text[place:]]) + "\n")
    assert numbers(plain).tobytes() == numbers(careful).tobytes()
    assert careful.rows.tolist() == [i + 2 + (i + 1 >= place) for i in range(12)]
