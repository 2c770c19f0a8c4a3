"""A wrong leaf of a document, key or value, is named in one short sentence, in the words of a file."""

import datetime
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from documents import PATHS, document
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.files.quote import shown
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.scenarios.show import show

BAD = [
    ({"plant": {"m": 0}}, r"plant\.m must be above 0, not 0"),
    ({"plant": {"m": True}}, r"plant\.m must be a number, not true"),
    ({"plant": {"m": "1.5"}}, r"plant\.m must be a number, not '1\.5'"),
    ({"plant": {"m": float("nan")}}, r"plant\.m must be a finite number, not nan"),
    ({"plant": {"m": float("inf")}}, r"plant\.m must be a finite number, not inf"),
    ({"plant": {"m": [1.0]}}, r"plant\.m must be a number, not \[1\.0\]"),
    ({"plant": {"m": {"x": 1}}}, r"unknown path 'plant\.m\.x'"),
    ({"plant": 3.0}, r"unknown path 'plant'"),
    ({"plant": {"mass": 1.0}}, r"unknown path 'plant\.mass'; the nearest are plant\."),
    ({"hi_gain": {"eps_h": 0.1}}, r"unknown path 'hi_gain\.eps_h'; the nearest are high_gain\.eps_h"),
    ({"high_gain": {"eps_h": 0.0}}, r"high_gain\.eps_h must be above 0"),
    ({"sliding_mode": {"delta_s": -1e-3}}, r"sliding_mode\.delta_s must be at least 0"),
    ({"duration": 0.0}, r"duration must be above 0"),
    ({"duration": 10**400}, r"duration must be a finite number"),
    ({"seed": 1.5}, r"seed must be a whole number"),
    ({"seed": -1}, r"seed must be a whole number"),
    ({"seed": 2**64}, r"seed must be a whole number"),
    ({"description": 3}, r"description must be a text, not 3"),
    ({"plant": {"drive": "steam"}}, r"plant\.drive must be one of virtual, requested, given, not 'steam'"),
    ({"muscle": {"curves": "printed"}}, r"muscle\.curves must be one of nguyen2019"),
]


@pytest.mark.parametrize(("content", "message"), BAD)
def test_a_wrong_leaf_is_named(content: dict[str, object], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        document(content, {})


@settings(max_examples=300)
@given(st.sampled_from(sorted(PATHS.parameters)), st.sampled_from([True, "1.5", [], float("nan"), float("-inf"), None]))
def test_one_broken_leaf_in_a_valid_document_is_the_one_named(path: str, broken: object) -> None:
    content: dict[str, Any] = tomllib.loads(show("paper-noisy"))
    at = content
    *tables, key = path.split(".")
    for name in tables:
        at = at.setdefault(name, {})
    at[key] = broken
    with pytest.raises(ScenarioError) as caught:
        document(content, {})
    assert str(caught.value).startswith(f"{path} must be")


def test_every_leaf_below_its_bound_is_named() -> None:
    """One path at a time, through its own name and through its group's."""
    paths = {**PATHS.parameters, **PATHS.groups()}
    bounded = {path: p for path, p in paths.items() if max(p.above, p.least) > float("-inf")}
    assert len(bounded) > 80
    for path, parameter in bounded.items():
        with pytest.raises(ScenarioError) as caught:
            document({}, {path: max(parameter.above, parameter.least) - 1.0})
        assert str(caught.value).startswith(f"{path} must be "), path


@settings(max_examples=300)
@given(st.sampled_from(sorted(PATHS.parameters)), st.data())
def test_a_key_with_a_slip_of_the_finger_is_named_with_valid_ones(path: str, data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(path) - 1))
    wrong = path[:at] + data.draw(st.sampled_from("abkx_.")) + path[at + data.draw(st.booleans()) :]
    try:
        document({}, {wrong: 1.0})
    except ScenarioError as error:
        message = str(error)
    else:
        message = ""
    if message.startswith("unknown"):
        assert message.startswith(f"unknown path {wrong!r}; the nearest are ")
        assert all(name in {**PATHS.parameters, **PATHS.groups()} for name in message.partition(" are ")[2].split(", "))


LEAVES = {
    "table for a number": ("[plant]\nm = {}\n", r"plant\.m must be a number"),
    "unknown empty table": ("[plnt]\n", "unknown path 'plnt'"),
    "one path twice": ('"plant.m" = 2.0\n[plant]\nm = 3.0\n', r"plant\.m"),
    "array of tables": ("[[plant]]\nm = 1.0\n", "unknown path 'plant'"),
    "table below a number": ("[plant.m]\nx = 1.0\n", r"plant\.m"),
    "time": ("plant.m = 12:00:00\n", r"plant\.m must be a number"),
    "hexadecimal digits in an array": (f"plant.m = [0x{'f' * 5000}]\n", r"plant\.m must be a number"),
    "hexadecimal seed": (f"seed = 0x{'f' * 5000}\n", "seed must be a whole number"),
    "decimal digits": (f"plant.m = {'9' * 4000}\n", r"plant\.m must be a finite number"),
    "logical seed": ("seed = true\n", "seed must be a whole number"),
    "real seed": ("seed = 1.0\n", "seed must be a whole number"),
    "array for a choice": ('plant.drive = ["virtual"]\n', r"plant\.drive must be one of"),
    "null character": ('description = "a\\u0000b"\n', "description"),
    "inline tables": ("a = " + "{a = " * 3000, "nested too deeply"),
    "carriage return": ("duration = 1.0\rstep = 1.0\n", "line 1"),
}


@pytest.mark.parametrize("what", LEAVES)
def test_a_wrong_leaf_of_a_file_is_one_sentence(what: str, tmp_path: Path) -> None:
    text, message = LEAVES[what]
    path = tmp_path / "mine.toml"
    path.write_bytes(text.encode())
    with pytest.raises(ScenarioError, match=message):
        prepare(path, None, {})


def test_a_wrong_leaf_of_a_file_names_the_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("[plant]\nm = 0\n")
    with pytest.raises(ScenarioError, match=r"mine\.toml.*plant\.m"):
        prepare(path, None, {})


@pytest.mark.parametrize("key", ["a" + ".a" * 2000, "k" * 5000], ids=["deep", "long"])
def test_a_sentence_about_a_key_is_short(key: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f"{key} = 1\n")
    with pytest.raises(ScenarioError) as caught:
        prepare(path, None, {})
    assert len(str(caught.value)) < 500 + len(str(path))


def test_values_are_shown_in_the_words_of_a_file() -> None:
    day = datetime.date(2020, 1, 1)
    assert shown([True, 1.5, "a\n", day, {"b": 1}, 10**5000]) == (
        "[true, 1.5, 'a\\n', 2020-01-01, a table, a number of many digits]"
    )
    assert len(shown("\0" * 10_000)) < 200
