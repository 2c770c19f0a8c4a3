"""A recording of three rows as text, and what is read when a text is written to a file: numbers, or a sentence."""

from pathlib import Path

import numpy as np
import pytest

from hillobs.studies.files.errors import RecordingError
from hillobs.studies.laboratory.recording import Recording, read_recording

HEAD = "time,position,force_1,force_2"
ROWS = "\n0,0.31,100,200\n0.001,0.32,101,201.5\n0.002,0.33,102.25,-1e-3\n"
TABLE = HEAD + ROWS


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
    return np.stack([recording.time, *recording.measured.values(), *recording.true.values()], axis=1)
