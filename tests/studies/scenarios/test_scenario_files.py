"""Where a scenario comes from: its file, the shipped one below it; a wrong file or name is one sentence."""

import random
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.scenarios.layers import shipped
from hillobs.studies.scenarios.prepare import prepare


def test_a_file_may_stand_on_a_shipped_scenario(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('base = "challenge"\nplant.m = 1.1\n')
    mine, below = prepare(path, None, {}), prepare("challenge", None, {})
    assert mine.scenario.given == {**below.scenario.given, "plant.m": 1.1}
    assert (mine.scenario.name, mine.scenario.description) == ("mine", below.scenario.description)
    for wrong in ('"my.toml"', "3", '"chalenge"'):
        path.write_text(f"base = {wrong}\n")
        with pytest.raises(ScenarioError, match=r"mine\.toml: base must be one of paper-clean, .*, not"):
            prepare(path, None, {})


def test_a_path_object_may_name_a_shipped_scenario() -> None:
    assert prepare(Path("paper-clean"), None, {}).scenario.name == "paper-clean"


FILES = {
    "syntax.toml": (b"[plant]\nm = \n", r"syntax\.toml: not valid TOML: .*line 2"),
    "bom.toml": (b"\xef\xbb\xbf[plant]\nm = 1.0\n", "byte-order mark"),
    "bytes.toml": (b"[plant]\n# \xff\xfe\n", "line 2 is not valid UTF-8"),
    "deep.toml": (b"a = " + b"[" * 3000 + b"]" * 3000, "nested too deeply"),
    "digits.toml": (b"duration = " + b"9" * 5000, "cannot be read|more than"),
    "date.toml": (b"duration = 2020-01-01\n", "duration must be a number"),
    "a[/x].toml": (b"[plant]\nm = -1\n", r"plant\.m must be above 0"),
    "run[bold].toml": (b"seed = true\n", "seed must be a whole number"),
    "-dash.toml": (b"x = 1\n", "unknown path 'x'"),
    "new\nline.toml": (b"= 1\n", "not valid TOML"),
    "large.toml": (b"#" * 1_100_000, "larger than"),
    "keys.toml": (b"plant.m = 1.0\nplant.m = 2.0\n", "not valid TOML"),
}


@pytest.mark.parametrize("name", FILES)
def test_a_wrong_file_is_one_sentence(name: str, tmp_path: Path) -> None:
    content, message = FILES[name]
    path = (tmp_path / "a[").joinpath("x].toml") if "/" in name else tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)
    with pytest.raises(ScenarioError, match=message) as caught:
        prepare(path, None, {})
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (None, "unknown scenario 'None'; there are paper-clean"),
        ("paper-cleam", "unknown scenario 'paper-cleam'; there are paper-clean, paper-noisy"),
        ("nowhere.toml", r"nowhere\.toml: cannot be read: No such file"),
        ("\0.toml", "cannot be read"),
    ],
)
def test_a_scenario_that_is_not_there_is_named(source: str, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        prepare(source, None, {})


def test_a_folder_is_no_scenario(tmp_path: Path) -> None:
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(ScenarioError, match="Is a directory"):
        prepare(tmp_path / "folder.toml", None, {})


def test_an_unknown_observer_is_named() -> None:
    with pytest.raises(ScenarioError, match="unknown observer 'luenberger'; there are high_gain, sliding_mode"):
        prepare("paper-clean", ["luenberger"], {})


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(noise=st.binary(max_size=200), dice=st.randoms(use_true_random=False))
def test_any_bytes_as_a_file_are_a_scenario_or_a_sentence(noise: bytes, dice: random.Random, tmp_path: Path) -> None:
    text = bytearray(shipped()["challenge"].encode())
    for byte in noise:
        text[dice.randrange(len(text))] = byte
    path = tmp_path / "mutated.toml"
    path.write_bytes(text)
    message = "mutated.toml"
    try:
        prepare(path, None, {})
    except ScenarioError as error:
        message = str(error)
    words = ("mutated.toml", "must be", "must not", "unknown path", "more than", "muscle")
    assert any(word in message for word in words)
