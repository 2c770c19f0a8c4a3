"""A damaged file is a recording or one sentence, and stays as it was: a corpus of them, and any."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.studies.files.errors import RecordingError
from hillobs.studies.laboratory.recording import read_recording
from places import CORPUS, DATA
from written_recording import numbers

REFUSED = CORPUS / "recordings"
EXPECTED = tomllib.loads((REFUSED / "expected.toml").read_text())


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_the_corpus_is_refused_or_read_as_expected(name: str) -> None:
    path = REFUSED / name
    before = path.read_bytes()
    try:
        recording = read_recording(path)
    except RecordingError as error:
        told = str(error).removeprefix(f"{path}: ")
    else:
        told = json.dumps(numbers(recording)[-1].tolist())
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
        recording = read_recording(path)
        assert (np.diff(recording.time) > 0).all()
        assert not np.isinf(numbers(recording)).any()
    except RecordingError as error:
        told = str(error)
    assert not told or told.startswith(f"{path}: ")
    assert len(told) < 600
    assert path.read_bytes() == bytes(raw)
