"""Scenarios: layers, groups, ties, and every way in which one can be wrong."""

import datetime
import json
import random
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hillobs.model.block import Block, BlockError, Parameter, Symbols, symbols
from hillobs.observers.ports import ESTIMATES
from hillobs.studies.files.errors import ResultError, ScenarioError
from hillobs.studies.files.quote import shown
from hillobs.studies.scenarios.layers import Layer, layer, layers, shipped
from hillobs.studies.scenarios.loops import all_paths
from hillobs.studies.scenarios.paths import block_paths
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.scenarios.scenario import Scenario, parse_change, scenario
from hillobs.studies.scenarios.show import show
from hillobs.studies.simulate.files import save
from hillobs.studies.simulate.run import simulate

PATHS = all_paths()


def document(content: dict[str, Any], changes: dict[str, Any]) -> Scenario:
    """A document with changes on top."""
    return scenario("s", [layer("", content), Layer("", changes)], PATHS)


def values(*layers: dict[str, object], **changes: float) -> dict[str, float]:
    """All numbers of a document with changes on top."""
    content = layers[0] if layers else {}
    given_numbers = document(content, changes).given
    return {path: PATHS.value(path, given_numbers) for path in PATHS.parameters}


def test_the_shipped_scenarios_are_valid_and_described() -> None:
    assert list(shipped()) == ["paper-clean", "paper-noisy", "challenge", "slack", "slack-deep", "activation"]
    for name in shipped():
        assert len(scenario(*layers(name, {}), PATHS).description) > 20


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


def test_the_layer_that_is_wrong_is_named(tmp_path: Path) -> None:
    """What a file gives is wrong whatever is asked for on top of it."""
    path = tmp_path / "mine.toml"
    path.write_text("[plant]\nm = 0\n")
    with pytest.raises(ScenarioError, match=r"^.*mine\.toml: plant\.m must be above 0"):
        prepare(path, None, {"plant.m": 2.0})
    path.write_text("[plant]\nm = 1\n")
    with pytest.raises(ScenarioError, match=r"^plant\.m must be above 0"):
        prepare(path, None, {"plant.m": 0.0})


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
        document({}, {path: value})
    except ScenarioError as error:
        message = str(error)
    assert message == "" or len(message) > 10


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


def test_every_group_sets_all_its_members_and_nothing_else() -> None:
    groups = PATHS.groups()
    assert {"muscle.k", "pulse.start", "high_gain.muscle.k", "controller.muscle.toe"} <= set(groups)
    for group, parameter in groups.items():
        value = parameter.default * 0.99 + 0.25 * (parameter.default == 0)
        members = PATHS.expand(group)
        assert len(members) == 2
        assert document({}, {group: value}).given == dict.fromkeys(members, value)


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


def test_a_path_is_a_text() -> None:
    with pytest.raises(ScenarioError, match=r"a path must be a text such as plant\.m, not 3"):
        simulate("paper-clean", changes={3: 1.0})  # type: ignore[dict-item]


def test_a_path_object_may_name_a_shipped_scenario() -> None:
    assert prepare(Path("paper-clean"), None, {}).scenario.name == "paper-clean"


def test_values_are_shown_in_the_words_of_a_file() -> None:
    day = datetime.date(2020, 1, 1)
    assert shown([True, 1.5, "a\n", day, {"b": 1}, 10**5000]) == (
        "[true, 1.5, 'a\\n', 2020-01-01, a table, a number of many digits]"
    )
    assert len(shown("\0" * 10_000)) < 200


@pytest.mark.parametrize("key", ["a" + ".a" * 2000, "k" * 5000], ids=["deep", "long"])
def test_a_sentence_about_a_key_is_short(key: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f"{key} = 1\n")
    with pytest.raises(ScenarioError) as caught:
        prepare(path, None, {})
    assert len(str(caught.value)) < 500 + len(str(path))


def refusal(attempt: Callable[[], object]) -> str:
    """The sentence with which something is refused; empty if it is done."""
    try:
        attempt()
    except (ScenarioError, BlockError, ResultError) as error:
        return str(error)
    return ""


@pytest.mark.parametrize("path", ["score.start", "noise.period", "record", "pulse1.start", "pulse2.stop"])
def test_a_time_beyond_every_integer_is_refused_or_right(path: str) -> None:
    """The kernel counts steps in 64 bits; what does not fit must not wrap around."""
    changes = {path: 1e300}
    if sentence := refusal(lambda: prepare("paper-noisy", None, changes)):
        assert path in sentence
        return
    grid = prepare("paper-noisy", None, changes).grid
    assert all(abs(n) < 2**63 for n in (grid.record, grid.hold, grid.window, *sum(grid.pulses, ())))


def test_a_period_far_below_the_step_is_no_way_to_switch_the_noise_off() -> None:
    with pytest.raises(ScenarioError, match=r"noise\.period"):
        prepare("paper-noisy", None, {"noise.period": 1e-14})


def test_a_pulse_that_ends_before_it_begins_is_refused() -> None:
    with pytest.raises(ScenarioError, match="pulse1"):
        prepare("paper-clean", None, {"pulse1.start": 3.0, "pulse1.stop": 2.0})


@pytest.mark.parametrize("value", [1.5, 2.0])
def test_a_force_factor_at_the_pole_is_refused(value: float) -> None:
    """g⁻¹ has its pole at g_max = 1.5; beyond it a muscle that lengthens comes out as one that shortens."""
    with pytest.raises(ScenarioError, match=r"z_max|g_max"):
        prepare("activation", None, {"plant.z_max": value})


@pytest.mark.parametrize("description", ["a\x7fb", "a\x85b\x9bc", 'a"b\\c\n\td', "Ünïcödé 😀"])
def test_what_show_prints_can_be_read_whatever_the_description(description: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    written = "".join(f"\\U{ord(c):08x}" for c in description)
    path.write_text(f'description = "{written}"\n', encoding="utf-8")
    assert tomllib.loads(show(str(path)))["description"] == description


def own(name: str = "mine", default: float = 20.0, state: str = "", **outputs: float) -> Block:
    """A user's observer that stands still, with one parameter and perhaps a state of its own."""
    x = symbols([*ESTIMATES, *([state] if state else [])])
    parameters = {"gain": Parameter(default, "a gain", "this test", above=0)}
    p, u = symbols(parameters), symbols("y1")
    dx = Symbols(dict.fromkeys(x, 0.0))
    dx["x1_hat"] = p.gain * (u.y1 - x.x1_hat)
    start = Symbols(dict.fromkeys(x, 2.0))
    y = Symbols({**{name: x[name] for name in ESTIMATES}, **outputs})
    return Block(name, x=x, u=u, p=p, parameters=parameters, dx=dx, x0=start, y=y)


BRIEF = {"duration": 0.05, "score.start": 0.0}


@pytest.mark.parametrize("name", ["a__b", "a_", "seed", "activation", "baseline", "plant", "muscle"])
def test_a_name_that_cannot_be_is_a_sentence(name: str) -> None:
    """A block whose name the code generator or the table of paths cannot take is refused, or it runs."""
    if sentence := refusal(lambda: simulate("paper-clean", [own(name)], BRIEF)):
        assert name in sentence
        return
    run = simulate("paper-clean", [own(name)], BRIEF)
    assert json.loads(run.attrs["parameters"])[f"{name}.gain"] == 20.0


@pytest.mark.parametrize(("name", "state"), [("x", "hat"), ("mine", "a/b"), ("mine", "a\0b")])
def test_a_state_of_ones_own_hides_nothing_and_can_be_written(name: str, state: str, tmp_path: Path) -> None:
    if sentence := refusal(lambda: save(simulate("paper-clean", [own(name, state=state)], BRIEF), tmp_path)):
        assert repr(state)[1:-1] in sentence
        return
    run = simulate("paper-clean", [own(name, state=state)], BRIEF)
    assert run.x_hat.dims == ("observer", "time", "state")
    assert run.u_hat.dims == ("observer", "time", "muscle")


def test_two_states_of_two_observers_do_not_share_a_variable() -> None:
    two = [own("a", state="b_c"), own("a_b", state="c")]
    if sentence := refusal(lambda: simulate("paper-clean", two, BRIEF)):
        assert "a_b" in sentence
        return
    run = simulate("paper-clean", two, BRIEF)
    assert {v.attrs["observer"] for v in run.data_vars.values() if "state" in v.attrs} == {"a", "a_b"}


def test_one_activation_of_ones_own_is_kept_or_refused() -> None:
    if sentence := refusal(lambda: simulate("paper-clean", [own(a1_hat=0.123)], BRIEF)):
        assert "a2_hat" in sentence
        return
    run = simulate("paper-clean", [own(a1_hat=0.123)], BRIEF)
    assert (run.a_hat.sel(muscle=1) == 0.123).all()


@pytest.mark.parametrize("default", [float("nan"), -1.0])
def test_a_default_out_of_its_own_bounds_is_refused(default: float) -> None:
    with pytest.raises((ScenarioError, BlockError), match="gain"):
        simulate("paper-clean", [own(default=default)], BRIEF)


def test_an_observer_that_leaves_its_own_domain_is_named() -> None:
    block = own()
    failing = replace(block, domain=Symbols(room=2.2 - block.x.x1_hat))
    run = simulate("paper-clean", [failing], BRIEF)
    assert json.loads(run.attrs["failures"])["mine"].startswith("mine: room, which must stay positive, is not at τ = ")


def test_a_held_input_is_held() -> None:
    """The same observer with y1 held over a step must not be the one that sees it move."""
    both = [own(), replace(own(), name="holding", held=frozenset(["y1"]))]
    run = simulate("paper-clean", both, {**BRIEF, "mine.gain": 200.0, "holding.gain": 200.0}).x_hat.sel(state="x1")
    assert 0 < abs(run.sel(observer="mine") - run.sel(observer="holding")).max() < 1e-4


def sampled(way: str) -> Block:
    """Counts samples or steps in a state n."""
    x = symbols([*ESTIMATES, "n"])
    still = Symbols(dict.fromkeys(ESTIMATES, 0.0))
    y = Symbols({name: x[name] for name in ESTIMATES})
    return Block(
        f"counter_{way}", x=x, dx=still, y=y, x0=Symbols(dict.fromkeys(ESTIMATES, 2.0)), **{way: Symbols(n=x.n + 1)}
    )


def test_states_move_at_samples_and_at_steps() -> None:
    settings_of_run = {"duration": 0.05, "score.start": 0.0, "step": 5e-4, "noise.period": 5e-3}
    counts = simulate("paper-noisy", [sampled("next"), sampled("per_step")], settings_of_run)
    assert counts.counter_next_n.values.tolist() == [1, 3, 5, 7, 9, 11]
    assert counts.counter_per_step_n.values.tolist() == [1, 21, 41, 61, 81, 101]


def test_a_sampled_observer_without_samples_is_said() -> None:
    """noise.period = 0 switches the samples off too: an observer that moves at samples stands still."""
    with pytest.raises((ScenarioError, BlockError), match=r"counter|sample"):
        simulate("paper-noisy", [sampled("next")], {**BRIEF, "noise.period": 0.0})


def test_an_observer_with_other_ports_is_refused_by_name() -> None:
    x, u = symbols(ESTIMATES), symbols("y1 y4")
    y, dx = Symbols(x), Symbols(dict.fromkeys(x, 0.0))
    with pytest.raises(BlockError, match=r"w: an observer sees t, y1, y2, y3\b.* only, not y4"):
        simulate("paper-clean", [Block("w", x=x, u=u, dx=dx, y=y)], BRIEF)
    del y["u2_hat"]
    with pytest.raises(BlockError, match="w: an observer must estimate u2_hat as well"):
        simulate("paper-clean", [Block("w", x=x, dx=dx, y=y)], BRIEF)
