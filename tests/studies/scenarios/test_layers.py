"""Layers, groups and ties: which number wins, and whom it reaches."""

from pathlib import Path

import pytest

from documents import PATHS, document
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.scenarios.layers import shipped
from hillobs.studies.scenarios.paths import block_paths
from hillobs.studies.scenarios.prepare import prepare
from places import OF_THE_PAIR


def values(*layers: dict[str, object], **changes: float) -> dict[str, float]:
    """All numbers of a document with changes on top."""
    content = layers[0] if layers else {}
    given_numbers = document(content, changes).given
    return {path: PATHS.value(path, given_numbers) for path in PATHS.parameters}


def test_the_shipped_scenarios_are_valid_and_described() -> None:
    assert list(shipped()) == [*OF_THE_PAIR, "arm", "hinge"]
    for name in shipped():
        assert len(prepare(name, "high_gain", {}).scenario.description) > 20


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
    muscles = values({"high_gain": {"muscle": {"k": 15.0}}, "muscle1": {"k": 17.0}})
    assert (muscles["high_gain.muscle1.k"], muscles["sliding_mode.muscle1.k"], muscles["muscle2.k"]) == (
        15.0,
        17.0,
        19.2308,
    )
    assert values({"uncertainty": {"offset": 0.02}})["baseline.Delta"] == 0.02


def test_every_path_reaches_exactly_the_blocks_that_use_it() -> None:
    """Changing a path changes the parameter vectors of its own Block and of those that share it, and of no other."""
    for path, parameter in PATHS.parameters.items():
        value = parameter.default + 0.25 * (1 if parameter.default < parameter.most else -1)
        given_numbers = {path: value}
        for block in PATHS.blocks:
            before, after = PATHS.values(block, {}), PATHS.values(block, given_numbers)
            changed = {p for p, b, a in zip(block_paths(block), before, after, strict=True) if a != b}
            users = {
                p
                for p in block_paths(block)
                if p == path or (PATHS.parameters[p].shared == path and p not in given_numbers)
            }
            assert changed == users, path


def test_every_group_sets_all_its_members_and_nothing_else() -> None:
    groups = PATHS.groups()
    assert {"muscle.k", "pulse.start", "high_gain.muscle.k", "controller.muscle.toe"} <= set(groups)
    for group, parameter in groups.items():
        value = parameter.default * 0.99 + 0.25 * (parameter.default == 0)
        members = PATHS.expand(group)
        assert len(members) == 2
        assert document({}, {group: value}).given == dict.fromkeys(members, value)


def test_the_layer_that_is_wrong_is_named(tmp_path: Path) -> None:
    """What a file gives is wrong whatever is asked for on top of it."""
    path = tmp_path / "mine.toml"
    path.write_text("[plant]\nm = 0\n")
    with pytest.raises(ScenarioError, match=r"^.*mine\.toml: plant\.m must be above 0"):
        prepare(path, None, {"plant.m": 2.0})
    path.write_text("[plant]\nm = 1\n")
    with pytest.raises(ScenarioError, match=r"^plant\.m must be above 0"):
        prepare(path, None, {"plant.m": 0.0})
