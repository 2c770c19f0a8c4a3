"""The header of a .sto file: a wrong one is refused, one whose counts are wrong is a remark."""

from pathlib import Path

import pytest

from written_recording import TABLE, reading, refusal


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
    recording = reading(folder, head + TABLE.replace(",", "\t"), "x.sto")
    assert recording.notes() == [
        "the header says nColumns=3, there are 4",
        "the header says nRows=99999999999, there are 3",
    ]
    assert len(recording) == 3
