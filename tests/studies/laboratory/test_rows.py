"""Rows: a broken cell is named, time rises, repeated rows are left out, gaps are kept and told."""

import random
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.studies.files.quote import ranges
from hillobs.studies.laboratory import lines
from written_recording import HEAD, TABLE, reading, refusal

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
            recording = reading(folder, text)
        assert recording.time.tolist() == [0, 0.5, 2]
        assert recording.rows.tolist() == [2, 5, 7]
        assert recording.repeated.tolist() == [3, 4, 6]
        assert recording.notes() == [
            "rows that repeat the one before are left out: 3–4, 6",
            "position has no value in 1 of 3 rows: 5",
            "force_1 has no value in 1 of 3 rows: 7",
            "force_2 has no value in 1 of 3 rows: 5",
        ]


def test_rows_are_told_briefly() -> None:
    assert ranges([1]) == "1"
    assert ranges([1, 2, 3, 5, 7, 8]) == "1–3, 5, 7–8"
    assert ranges(range(0, 40, 2)) == "0, 2, 4, 6, 8 and 15 more"
