"""A mapping says which column is which, from the command line or a file; a wrong one is a sentence."""

import re
from pathlib import Path

import pytest

from hillobs.studies.files.errors import RecordingError, ScenarioError
from hillobs.studies.laboratory.mapping import read_mapping
from written_recording import HEAD, TABLE, numbers, reading, refusal


def test_a_simulation_of_ours_is_a_recording_without_units(folder: Path) -> None:
    text = "# units: 1,1,1,1,1\nt,x1,y2,high_gain.x1_hat,y3\n0,2.6,0.1,2.62,0.2\n"
    recording = reading(folder, text, mapping={"time": "t", "position": "x1", "force_1": "y2", "force_2": "y3[N]"})
    assert numbers(recording).tolist() == [[0, 2.6, 0.1, 0.2]]


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
    assert swapped["force_1"].tolist() == [200, 201.5, -1e-3]


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


@pytest.mark.parametrize(
    ("mapping", "sentence"),
    [
        ({"position": Path("x")}, "the column of position in mapping must be a text"),
        ({"position": None}, "the column of position in mapping must be a text, not None"),
        ({3: "x"}, "a name in mapping must be a text"),
        ("position=x", "mapping must be a dict, not 'position=x'"),
    ],
)
def test_a_mapping_from_python_is_of_texts(mapping, sentence: str, folder: Path) -> None:
    with pytest.raises(ScenarioError, match=re.escape(sentence)):
        reading(folder, "time,position,force_1,force_2\n0,1,2,3\n1,1,2,3\n", mapping=mapping)
