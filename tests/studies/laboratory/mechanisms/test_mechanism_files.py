"""Mechanism files: the way there and back, and what is wrong with one in a sentence."""

import copy
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.model.curves import DEGROOTE_FREGLY2016
from hillobs.model.skeleton.paths import Path as MusclePath
from hillobs.model.skeleton.paths import constant_moment_arms, polynomial
from hillobs.model.skeleton.tree import GROUND, PIN, SLIDER, WELD, Joint, Link, Tree
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.files.toml import toml_document
from hillobs.studies.laboratory.mechanisms.mechanism import Mechanism
from hillobs.studies.laboratory.mechanisms.reading import mechanism_of, read_mechanism
from hillobs.studies.laboratory.mechanisms.writing import mechanism_file, mechanism_text
from hillobs.studies.laboratory.muscles import Muscle, muscle_pair, numbers_of, read_muscles
from places import DATA, RECORDINGS

SHIPPED = ["arm", "hinge_pair", "dynamometer"]
TEXT = """
description = "two joints, two muscles"
gravity = [0, -9.81, 0]
[links.upper]
mass = 1.3
com = [0.02, -0.21, 0.01]
inertia = [0.03, 0.004, 0.028, 0.001, -0.002, 0.0005]
[links.lower]
mass = 0.8
inertia = [0.012, 0.002, 0.011, 0, 0, 0]
[joints.shoulder]
type = "pin"
parent = "ground"
child = "upper"
at = [0, 0.8, 0.1]
orientation = [0.1, -0.2, 0.3]
axis = [0, 0, 2]
range = [-1, 0.5]
coordinate = "r_shoulder_elev"
[joints.reach]
type = "slider"
parent = "upper"
child = "lower"
child_at = [0, 0.05, 0]
child_orientation = [0, 0, 0.2]
axis = [0, -1, 0]
stiffness = 40
rest = 0.1
damping = 2
[muscle]
curves = "degroote_fregly2016"
v_max = 10
[muscles.BRA]
F_max = { value = 900, sd = "5%" }
optimal_fibre_length = 0.09
tendon_slack_length = 0.05
pennation = { value = 0.1, sd = 0.02 }
path = { joints = ["shoulder", "reach"], order = 2, coefficients = [0.3, 0.1, 0, 0.02, 0, 0.01] }
[muscles.TRI]
F_max = 600
optimal_fibre_length = 0.11
tendon_slack_length = 0.1
path = { length = 0.25, moment_arms = { shoulder = -0.02 } }
"""


def document() -> dict[str, Any]:
    return tomllib.loads(TEXT)


def test_a_mechanism_file_means_what_it_says() -> None:
    arm = mechanism_of(document())
    assert arm.tree.coordinates == ("shoulder", "reach")
    upper, reach = arm.tree.links["upper"], arm.tree.joints["reach"]
    assert (upper.mass, upper.com) == (1.3, (0.02, -0.21, 0.01))
    assert upper.tensor[0, 1] == 0.001
    assert (reach.stiffness, reach.rest, reach.damping) == (40.0, 0.1, 2.0)
    assert arm.tree.joints["shoulder"].alias == "r_shoulder_elev"
    assert arm.muscles["BRA"].pennation == 0.1
    assert arm.muscles["BRA"].sds == {"F_max": 45.0, "pennation": 0.02}
    assert arm.muscles["TRI"].v_max == 10.0
    # q₂ fastest: 00 01 02 10 11 20
    assert arm.paths["BRA"].terms == {(0, 0): 0.3, (0, 1): 0.1, (1, 0): 0.02, (2, 0): 0.01}
    # L = length − r q
    assert arm.paths["TRI"].terms == {(0,): 0.25, (1,): 0.02}


@pytest.mark.parametrize("name", [*SHIPPED, "inline"])
def test_a_mechanism_as_a_file_is_the_same_mechanism(name: str) -> None:
    arm = mechanism_of(document()) if name == "inline" else read_mechanism(RECORDINGS / f"{name}.toml")
    text = mechanism_text(arm)
    again = mechanism_of(tomllib.loads(text))
    assert again == arm
    assert mechanism_text(again) == text
    assert mechanism_of(mechanism_file(arm)) == arm


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_mechanism_is_written_as_it_is(name: str) -> None:
    path = RECORDINGS / f"{name}.toml"
    assert mechanism_text(read_mechanism(path)) == path.read_text(encoding="utf-8")


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """No number of a body is next to nothing and not 0."""
    return st.floats(low, high).filter(lambda value: value == 0 or abs(value) > 1e-9)


PLACE = st.tuples(*[numbers(-10, 10)] * 3)
ANGLES = st.tuples(*[numbers(-6, 6)] * 3)
POSITIVE = numbers(0, 1e3)
DESCRIPTIONS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=20)


@st.composite
def mechanisms(draw: st.DrawFn) -> Mechanism:
    """Chains of pins, sliders and welds with muscles along all of them; the first joint moves."""
    kinds = [draw(st.sampled_from([PIN, SLIDER])), *draw(st.lists(st.sampled_from([PIN, SLIDER, WELD]), max_size=3))]
    links = {
        f"l {at}": Link(draw(st.floats(0.1, 1e3)), draw(PLACE), (1.0, 1.0, 1.0, 0, 0, 0)) for at in range(len(kinds))
    }
    joints = {f"j{at}": draw(_joint(kind, at)) for at, kind in enumerate(kinds)}
    tree = Tree(links, joints, draw(PLACE))
    crossed = draw(st.lists(st.sampled_from(tree.coordinates), unique=True, max_size=3))
    arms = {joint: draw(numbers(-9, 9)) for joint in crossed}
    paths = {"m1": constant_moment_arms(draw(st.floats(0.01, 9)), arms), "m2": draw(_polynomial(crossed))}
    defaults = {key: parameter.default for key, parameter in numbers_of(DEGROOTE_FREGLY2016).items()}
    muscles = {
        name: Muscle(DEGROOTE_FREGLY2016, draw(st.floats(1, 1e4)), 0.1, 0.2, 10.0, defaults, {}, draw(numbers(0, 1.4)))
        for name in paths
    }
    return Mechanism(tree, muscles, paths, draw(DESCRIPTIONS))


@st.composite
def _joint(draw: st.DrawFn, kind: str, at: int) -> Joint:
    frames = [draw(PLACE), draw(ANGLES), draw(PLACE), draw(ANGLES)]
    parent, child = f"l {at - 1}" if at else GROUND, f"l {at}"
    if kind == WELD:
        return Joint(parent, child, kind, (0.0, 0.0, 1.0), *frames)
    locked = draw(st.none() | numbers(-9, 9)) if at else None
    return Joint(
        parent,
        child,
        kind,
        draw(PLACE.filter(any)),
        *frames,
        draw(POSITIVE),
        draw(numbers(-9, 9)),
        draw(POSITIVE),
        draw(st.none() | st.tuples(st.floats(-9, -1), st.floats(1, 9))),
        locked,
        locked is None and draw(st.booleans()),
        draw(st.sampled_from(["", "r_elbow_flex"])),
        draw(st.sampled_from(["", "r_elbow"])),
    )


@st.composite
def _polynomial(draw: st.DrawFn, joints: list[str]) -> MusclePath:
    order = draw(st.integers(0, 3))
    count = {0: 1, 1: order + 1, 2: (order + 1) * (order + 2) // 2, 3: (order + 1) * (order + 2) * (order + 3) // 6}
    coefficients = st.lists(numbers(-9, 9), min_size=count[len(joints)], max_size=count[len(joints)])
    return polynomial(joints, order, draw(coefficients))


@given(mechanisms())
def test_no_number_of_any_mechanism_is_lost_in_its_file(arm: Mechanism) -> None:
    assert mechanism_of(tomllib.loads(mechanism_text(arm))) == arm


VALUES = st.recursive(
    st.booleans() | st.integers(-(2**60), 2**60) | st.floats(allow_nan=False, allow_infinity=False) | DESCRIPTIONS,
    lambda inner: st.lists(inner, max_size=6) | st.dictionaries(DESCRIPTIONS, inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(DESCRIPTIONS, VALUES, max_size=5))
def test_what_is_written_as_toml_is_read_as_the_same(content: dict[str, Any]) -> None:
    assert tomllib.loads(toml_document(content)) == content


def test_a_locked_joint_stays_in_the_paths_of_a_file() -> None:
    content = document()
    content["joints"]["reach"]["locked"] = 0.5
    # 0.3 + 0.1 · 0.5 + 0.02 q + 0.01 q²
    assert mechanism_of(content).paths["BRA"].terms == pytest.approx({(0,): 0.35, (1,): 0.02, (2,): 0.01})


def test_paths_may_be_in_a_file_beside(tmp_path: Path) -> None:
    content = tomllib.loads((RECORDINGS / "arm.toml").read_text())
    for muscle in content["muscles"].values():
        del muscle["path"]
    (tmp_path / "fitted.xml").write_bytes((DATA / "arm26_paths_order5.xml").read_bytes())
    text = f'paths = "fitted.xml"\n{toml_document(content)}'
    (tmp_path / "arm.toml").write_text(text)
    assert read_mechanism(tmp_path / "arm.toml") == read_mechanism(RECORDINGS / "arm.toml")
    (tmp_path / "arm.toml").write_text(text.replace('coordinate = "r_elbow_flex"', ""))
    with pytest.raises(ScenarioError, match="the path of TRIlong crosses 'r_elbow_flex', which is no coordinate"):
        read_mechanism(tmp_path / "arm.toml")
    (tmp_path / "arm.toml").write_text(text.replace("[muscles.BRA]", "[muscles.unknown]"))
    with pytest.raises(ScenarioError, match="muscle unknown has no path"):
        read_mechanism(tmp_path / "arm.toml")


def change(*path: str, to: object = None) -> Callable[[dict[str, Any]], None]:
    """A change of a document at a path: another value, or none."""

    def changed(content: dict[str, Any]) -> None:
        table = content
        for key in path[:-1]:
            table = table[key]
        if to is None:
            del table[path[-1]]
        else:
            table[path[-1]] = to

    return changed


LINK = {"mass": 1, "inertia": [1, 1, 1, 0, 0, 0]}
WELDED = {"type": "weld", "parent": "ground"}
PATH = ("muscles", "BRA", "path")
WRONG = {
    "links hang in a circle": change("joints", "shoulder", "parent", to="lower"),
    "link lower hangs in two joints, reach and more; a tree": change("joints", "more", to={**WELDED, "child": "lower"}),
    "link hand hangs in no joint": change("links", "hand", to=LINK),
    "joint shoulder: its parent 'wall' is no link": change("joints", "shoulder", "parent", to="wall"),
    "joint reach: its child 'hand' is no link": change("joints", "reach", "child", to="hand"),
    "joint shoulder: its axis is 0 0 0, which": change("joints", "shoulder", "axis", to=[0, 0, 0]),
    "joint shoulder: its range must rise": change("joints", "shoulder", "range", to=[1, -1]),
    "link upper: its inertia is not positive definite": change("links", "upper", "inertia", to=[1, 1, -1, 0, 0, 0]),
    "links.upper.inertia must be a list of 6 numbers, not [1, 2]": change("links", "upper", "inertia", to=[1, 2]),
    "links.upper.mass is missing": change("links", "upper", "mass"),
    "links.upper.mass must be at least 0, not -1": change("links", "upper", "mass", to=-1),
    "links.upper.mass must be a number, not 'heavy'": change("links", "upper", "mass", to="heavy"),
    "links.upper.com[1] must be at least -20, not -210": change("links", "upper", "com", to=[0, -210, 0]),
    "links.upper must be a table, [links.upper], not 3": change("links", "upper", to=3),
    "links must be a table, [links], not 3": change("links", to=3),
    "unknown key 'links.upper.weight'": change("links", "upper", "weight", to=3),
    "unknown key 'joint'": change("joint", to={}),
    "gravity must be a list of 3 numbers, not -9.81": change("gravity", to=-9.81),
    "joints.shoulder.type is missing": change("joints", "shoulder", "type"),
    "joints.shoulder.type must be one of pin, slider, weld, not 'ball'": change(
        "joints", "shoulder", "type", to="ball"
    ),
    "joints.shoulder.axis is missing": change("joints", "shoulder", "axis"),
    "joints.shoulder.range[1] must be at most 12, not 90 (rad; is it in degrees?)": change(
        "joints", "shoulder", "range", to=[0, 90]
    ),
    "joints.shoulder.prescribed must be true or false, not 1": change("joints", "shoulder", "prescribed", to=1),
    "unknown key 'joints.wrist.axis'": change("joints", "wrist", to={**WELDED, "child": "upper", "axis": [0, 0, 1]}),
    "a mechanism needs a muscle or more": change("muscles"),
    "muscle BRA has no path": change(*PATH),
    "joint reach moves no mass; give the links beyond it a mass": change("links", "lower", "mass", to=0),
    "muscles.BRA.path crosses wrist, which is no moving joint; there are shoulder, reach": change(
        *PATH, to={"length": 0.2, "moment_arms": {"wrist": 0.01}}
    ),
    "muscles.BRA.path: a polynomial of order 2 in shoulder has 3 coefficients, not 2": change(
        *PATH, to={"joints": ["shoulder"], "order": 2, "coefficients": [1, 2]}
    ),
    "muscles.BRA.path: a polynomial of order 40 in 1 joints is too large": change(
        *PATH, to={"joints": ["shoulder"], "order": 40, "coefficients": [1]}
    ),
    "muscles.BRA.path: 'shoulder' is there twice": change(
        *PATH, to={"joints": ["shoulder"] * 2, "order": 1, "coefficients": [1, 2, 3]}
    ),
    "muscles.BRA.path.order is missing": change(*PATH, "order"),
    "muscles.BRA.path.order must be a whole number of at least 0, not 1.5": change(*PATH, "order", to=1.5),
    "muscles.BRA.path.joints must be a list of names": change(*PATH, "joints", to="shoulder"),
    "muscles.BRA.path.coefficients[0] must be a number, not '1'": change(*PATH, "coefficients", to=["1"] * 6),
    "muscles.BRA.path must be a table": change(*PATH, to=3),
    "muscles.BRA.path.length is missing": change(*PATH, to={"moment_arms": {"shoulder": 0.01}}),
    "muscles.BRA.path.moment_arms.shoulder must be at most 10, not 20": change(
        *PATH, to={"length": 0.2, "moment_arms": {"shoulder": 20}}
    ),
    "unknown key 'muscles.BRA.path.order'": change(*PATH, to={"length": 1, "moment_arms": {}, "order": 1}),
    "muscles.BRA.pennation must be at most 1.4, not 12": change("muscles", "BRA", "pennation", to=12),
    "muscles.BRA.curves is missing": change("muscle", "curves"),
    "muscles.BRA.F_max is missing": change("muscles", "BRA", "F_max"),
    "unknown key 'muscles.BRA.F'": change("muscles", "BRA", "F", to=3),
    "unknown key 'muscle.path'": change("muscle", "path", to={}),
    "a muscle and a joint are both called reach": lambda content: content["muscles"].update(
        reach=content["muscles"].pop("BRA")
    ),
    "'b r a' is no name for a joint, a muscle or a point": lambda content: content["muscles"].update(
        {"b r a": content["muscles"].pop("BRA")}
    ),
    "paths must be a text, not 3": change("paths", to=3),
    "points.hand: its link 'nowhere' is none; there are": change(
        "points", to={"hand": {"link": "nowhere", "at": [0, 0, 0]}}
    ),
    "points.hand.at is missing": change("points", to={"hand": {"link": "lower"}}),
    "points.hand.at must be a list of 3 numbers": change("points", to={"hand": {"link": "lower", "at": [0, 0]}}),
    "a point and a joint or muscle are both called BRA": change(
        "points", to={"BRA": {"link": "lower", "at": [0, 0, 0]}}
    ),
}


@pytest.mark.parametrize("sentence", WRONG)
def test_what_is_wrong_with_a_file_is_a_sentence(sentence: str) -> None:
    content = document()
    WRONG[sentence](content)
    with pytest.raises(ScenarioError) as caught:
        mechanism_of(content)
    assert str(caught.value).startswith(sentence)
    assert "\n" not in str(caught.value)


def test_a_joint_is_locked_or_prescribed() -> None:
    content = document()
    content["joints"]["reach"] |= {"locked": 0.1, "prescribed": True}
    with pytest.raises(ScenarioError, match=r"joints\.reach: is locked and prescribed"):
        mechanism_of(content)


def test_a_file_that_cannot_be_read_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"none\.toml: cannot be read: No such file"):
        read_mechanism(tmp_path / "none.toml")
    (tmp_path / "odd.toml").write_text("links = {")
    with pytest.raises(ScenarioError, match=r"odd\.toml: not valid TOML"):
        read_mechanism(tmp_path / "odd.toml")
    (tmp_path / "short.toml").write_text(TEXT.replace("mass = 1.3", ""))
    with pytest.raises(ScenarioError, match=r"short\.toml: links\.upper\.mass is missing"):
        read_mechanism(tmp_path / "short.toml")


def test_the_muscles_of_a_pair_are_not_pennate() -> None:
    content = tomllib.loads((RECORDINGS / "dgf_smooth.toml").read_text())
    for place in ("muscle", "muscle1"):
        pennate = copy.deepcopy(content)
        pennate.setdefault(place, {})["pennation"] = 0.1
        with pytest.raises(ScenarioError, match=f"unknown key '{place}.pennation'"):
            muscle_pair(pennate)
    pair = read_muscles(RECORDINGS / "dgf_smooth.toml")
    muscle = pair.muscle1
    sizes = (muscle.F_max, muscle.optimal_fibre_length, muscle.tendon_slack_length, muscle.v_max)
    with pytest.raises(ScenarioError, match=r"muscle1\.pennation must be 0, not 0\.1"):
        type(pair)(pair.mass, pair.C, Muscle(muscle.curves, *sizes, muscle.numbers, {}, 0.1), pair.muscle2)
