"""Scenarios: layers, groups, ties, and every way in which one can be wrong."""

import json
import random
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hillobs.studies.loops import full_table
from hillobs.studies.prepare import prepare
from hillobs.studies.scenario import parse_change, read, scenario, shipped
from hillobs.studies.show import show
from hillobs.studies.simulate import simulate
from hillobs.studies.table import ScenarioError, block_paths

TABLE = full_table()


def values(*layers: dict[str, object], **changes: float) -> dict[str, float]:
    """All numbers of a document with changes on top."""
    content = layers[0] if layers else {}
    given_numbers = scenario("s", content, changes, TABLE).given
    return {path: TABLE.value(path, given_numbers) for path in TABLE.paths}


def test_the_shipped_scenarios_are_valid_and_described() -> None:
    assert list(shipped()) == ["paper-clean", "paper-noisy", "challenge", "slack", "slack-deep", "activation"]
    for name in shipped():
        assert len(scenario(*read(name), {}, TABLE).description) > 20


def test_a_group_sets_its_members_and_a_member_of_the_same_layer_wins() -> None:
    both = values({"muscle": {"k": 18.0}, "muscle1": {"k": 17.0}})
    assert (both["muscle1.k"], both["muscle2.k"]) == (17.0, 18.0)
    over = values({"muscle1": {"k": 17.0}}, **{"muscle.k": 16.0})
    assert (over["muscle1.k"], over["muscle2.k"]) == (16.0, 16.0)
    assert values({"pulse": {"amplitude": 0.1}})["pulse2.amplitude"] == 0.1


def test_shared_numbers_follow_until_they_are_untied() -> None:
    tied = values({"plant": {"m": 2.0}})
    assert {tied[path] for path in tied if path.endswith(".m")} == {2.0}
    untied = values({"plant": {"m": 2.0}, "high_gain": {"m": 1.5}})
    assert (untied["high_gain.m"], untied["sliding_mode.m"], untied["controller.m"]) == (1.5, 2.0, 2.0)
    # a later layer's shared value does not tie again
    assert values({"high_gain": {"m": 1.5}}, **{"plant.m": 3.0})["high_gain.m"] == 1.5
    own = values({"high_gain": {"muscle": {"k": 15.0}}, "muscle1": {"k": 17.0}})
    assert (own["high_gain.muscle1.k"], own["sliding_mode.muscle1.k"], own["muscle2.k"]) == (15.0, 17.0, 19.2308)
    assert values({"uncertainty": {"offset": 0.02}})["baseline.Delta"] == 0.02


def test_every_path_reaches_exactly_the_blocks_that_use_it() -> None:
    """Changing a path changes the parameter vectors of its own Block and of those that share it, and of no other."""
    for path, parameter in TABLE.paths.items():
        value = parameter.default + 0.25 * (1 if parameter.default < parameter.most else -1)
        given_numbers = {path: value}
        for block in TABLE.blocks:
            before, after = TABLE.values(block, {}), TABLE.values(block, given_numbers)
            changed = {p for p, b, a in zip(block_paths(block), before, after, strict=True) if a != b}
            users = {
                p for p in block_paths(block) if p == path or (TABLE.paths[p].shared == path and p not in given_numbers)
            }
            assert changed == users, path


@pytest.mark.parametrize("name", shipped())
def test_what_show_prints_is_the_same_scenario(name: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(show(name), encoding="utf-8")
    short = {"duration": 0.2, "score.start": 0.1}
    ours, theirs = simulate(name, changes=short), simulate(path, changes=short)
    assert ours.x_hat.equals(theirs.x_hat)
    assert ours.x.equals(theirs.x)
    assert json.loads(ours.attrs["parameters"]) == json.loads(theirs.attrs["parameters"])
    assert ours.attrs["description"] == theirs.attrs["description"]


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
        scenario("s", content, {}, TABLE)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"step": 30.0}, "step = 30 must not exceed duration = 20"),
        ({"step": 3e-4}, "must be a whole multiple of step = 0.0003"),
        ({"record": 0.0007}, "record = 0.0007 must be a whole multiple of step"),
        ({"noise.period": 0.0033}, "noise.period = 0.0033 must be a whole multiple"),
        ({"pulse1.start": 0.12345}, "pulse1.start = 0.12345 must be a whole multiple"),
        ({"duration": 1e12}, "more than 1,000,000,000 steps"),
        ({"duration": 1e5}, "keeps more than 1,000,000 points"),
        ({"muscle.k": 40.0}, "muscle1: k·toe = 1.6 must be below 2.5 F_toe = 1.25"),
        ({"high_gain.muscle2.k": 40.0}, "high_gain.muscle2: k·toe"),
    ],
)
def test_numbers_that_do_not_fit_together_are_named(changes: dict[str, float], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        prepare("paper-clean", None, changes)


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
    with pytest.raises(ScenarioError, match="unknown observer 'kalman'; there are high_gain, sliding_mode"):
        prepare("paper-clean", ["kalman"], {})


@pytest.mark.parametrize(
    "text", ["plant.m", "=1", "", "plant.m=1_000", "plant.m=١", "plant.m= 1", "plant.m=0x1", "plant.m=nan"]
)
def test_a_change_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(ScenarioError):
        parse_change(text)


@given(st.text(max_size=60))
def test_any_text_as_a_change_is_a_number_or_a_sentence(text: str) -> None:
    message = ""
    try:
        path, value = parse_change(text)
        scenario("s", {}, {path: value}, TABLE)
    except ScenarioError as error:
        message = str(error)
    assert message == "" or len(message) > 10


@settings(max_examples=300)
@given(st.sampled_from(sorted(TABLE.paths)), st.sampled_from([True, "1.5", [], float("nan"), float("-inf"), None]))
def test_one_broken_leaf_in_a_valid_document_is_the_one_named(path: str, broken: object) -> None:
    content: dict[str, Any] = tomllib.loads(show("paper-noisy"))
    at = content
    *tables, key = path.split(".")
    for name in tables:
        at = at.setdefault(name, {})
    at[key] = broken
    with pytest.raises(ScenarioError) as caught:
        scenario("s", content, {}, TABLE)
    assert str(caught.value).startswith(f"{path} must be")


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
