"""What `show` prints is read as the same scenario."""

import json
import tomllib
from pathlib import Path

import pytest

from hillobs.studies.scenarios.layers import shipped
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.scenarios.show import show
from hillobs.studies.simulate.run import simulate
from places import OF_THE_PAIR


@pytest.mark.parametrize("name", OF_THE_PAIR)
def test_what_show_prints_is_the_same_scenario(name: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(show(name), encoding="utf-8")
    short = {"duration": 0.2, "score.start": 0.1}
    ours, theirs = simulate(name, changes=short), simulate(path, changes=short)
    assert ours.x_hat.equals(theirs.x_hat)
    assert ours.x.equals(theirs.x)
    assert json.loads(ours.attrs["parameters"]) == json.loads(theirs.attrs["parameters"])
    assert ours.attrs["description"] == theirs.attrs["description"]


@pytest.mark.parametrize("name", sorted({*shipped()} - {*OF_THE_PAIR}))
def test_what_show_prints_of_a_mechanism_has_the_same_numbers(name: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(show(name), encoding="utf-8")
    ours, theirs = (prepare(source, "high_gain", {}) for source in (name, path))
    assert ours.scenario.world.choices == theirs.scenario.world.choices
    assert {p: ours.value(p) for p in ours.paths.parameters} == {p: theirs.value(p) for p in ours.paths.parameters}


@pytest.mark.parametrize("description", ["a\x7fb", "a\x85b\x9bc", 'a"b\\c\n\td', "Ünïcödé 😀"])
def test_what_show_prints_can_be_read_whatever_the_description(description: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    written = "".join(f"\\U{ord(c):08x}" for c in description)
    path.write_text(f'description = "{written}"\n', encoding="utf-8")
    assert tomllib.loads(show(str(path)))["description"] == description
