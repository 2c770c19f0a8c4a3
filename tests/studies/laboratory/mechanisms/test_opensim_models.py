"""OpenSim models read without OpenSim, against what OpenSim says of them."""

import gzip
import json
import re
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.model.skeleton.frames import about, frame
from hillobs.model.skeleton.newton_euler import equation_of_motion
from hillobs.model.skeleton.paths import moment_arms
from hillobs.model.skeleton.tree import PIN, SLIDER, Tree
from hillobs.studies.laboratory.mechanisms.from_opensim import mechanism_from
from hillobs.studies.laboratory.mechanisms.mechanism import Mechanism
from hillobs.studies.laboratory.mechanisms.reading import read_mechanism
from hillobs.studies.laboratory.opensim.document import Component
from hillobs.studies.laboratory.opensim.frames import Fixed, angles
from hillobs.studies.laboratory.opensim.model import OpenSimModel, read_model
from hillobs.studies.laboratory.opensim.motion import Axis, single
from hillobs.studies.laboratory.opensim.paths import read_paths
from hillobs.studies.laboratory.opensim.xml import Element
from places import DATA, RECORDINGS

PATHS = DATA / "arm26_paths_order5.xml"
# a few hundred operations on numbers of order 1 to 50, here and in OpenSim
ROUNDING = 1e-12


@pytest.fixture(scope="module")
def wrapped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """arm26 as it is shipped: Thelen's muscles, geometry that wraps."""
    path = tmp_path_factory.mktemp("models") / "arm26.osim"
    path.write_bytes(gzip.decompress((DATA / "arm26.osim.gz").read_bytes()))
    return path


def polynomial_arm(**options) -> Mechanism:
    return mechanism_from(read_model(DATA / "arm26_polynomial.osim", **options), "arm26_polynomial.osim")


# OpenSim's own values at shoulder −0.3, elbow 1.0, in m
LENGTHS = {
    "TRIlong": "0.289837808",
    "TRIlat": "0.189727462",
    "TRImed": "0.177355266",
    "BIClong": "0.405720497",
    "BICshort": "0.320913235",
    "BRA": "0.133496754",
}


def lengths(mechanism: Mechanism, **at: float) -> dict[str, float]:
    q = {name: ca.SX(value) for name, value in at.items()}
    return {name: float(path.length(q)) for name, path in mechanism.paths.items()}


@pytest.mark.parametrize("source", ["model", "file", "shipped"])
def test_lengths_are_those_of_opensim_in_all_digits(source: str, wrapped: Path) -> None:
    arm = {
        "model": polynomial_arm,
        "file": lambda: mechanism_from(read_model(wrapped, PATHS), "arm26.osim"),
        "shipped": lambda: read_mechanism(RECORDINGS / "arm.toml"),
    }[source]()
    found = lengths(arm, shoulder=-0.3, elbow=1.0)
    assert {name: f"{value:.9f}" for name, value in found.items()} == LENGTHS


def test_the_wrapped_model_with_polynomials_has_the_same_tree_and_paths(wrapped: Path) -> None:
    thelen, degroote = mechanism_from(read_model(wrapped, PATHS), "x"), polynomial_arm()
    assert thelen.tree == degroote.tree
    assert thelen.paths == degroote.paths
    assert {muscle.curves.name for muscle in thelen.muscles.values()} == {"thelen2003"}
    assert {muscle.curves.name for muscle in degroote.muscles.values()} == {"degroote_fregly2016"}
    for name, muscle in degroote.muscles.items():
        other = thelen.muscles[name]
        assert muscle.sizes == other.sizes
        assert (muscle.pennation, muscle.numbers["tendon_strain"]) == (other.pennation, other.numbers["tendon_strain"])
    # arm26's own numbers of Thelen's curves, which are not the defaults
    numbers = thelen.muscles["BRA"].numbers
    assert [numbers[key] for key in ("A_f", "F_len", "k_PE", "gamma")] == [0.3, 1.8, 4.0, 0.5]


class Skeleton:
    """M, h, L and R of a mechanism as a function of numbers."""

    def __init__(self, mechanism: Mechanism) -> None:
        names = mechanism.tree.coordinates
        q, dq = (ca.SX.sym(name, len(names)) for name in ("q", "dq"))
        # springs and dampers are no part of what OpenSim calls M, c and g
        bare = {name: replace(joint, stiffness=0.0, damping=0.0) for name, joint in mechanism.tree.joints.items()}
        motion = equation_of_motion(
            Tree(mechanism.tree.links, bare, mechanism.tree.gravity),
            dict(zip(names, ca.vertsplit(q), strict=True)),
            dict(zip(names, ca.vertsplit(dq), strict=True)),
        )
        L = [path.length(dict(zip(names, ca.vertsplit(q), strict=True))) for path in mechanism.paths.values()]
        R = moment_arms(ca.vertcat(*L), q)
        self._at = ca.Function("skeleton", [q, dq], [motion.M, motion.h, ca.vertcat(*L), R])

    def __call__(self, q: list[float], dq: list[float]) -> list[np.ndarray]:
        return [np.array(value) for value in self._at(q, dq)]


@pytest.mark.parametrize("source", ["imported", "shipped"])
def test_the_arm_is_that_of_opensim(source: str) -> None:
    arm = polynomial_arm() if source == "imported" else read_mechanism(RECORDINGS / "arm.toml")
    skeleton = Skeleton(arm)
    states = json.loads((DATA / "arm_states.json").read_text())["states"]
    assert len(states) == 20
    for state in states:
        M, h, L, R = skeleton(state["q"], state["qd"])
        assert np.abs(M - state["M"]).max() <= ROUNDING
        assert np.abs(h[:, 0] - state["c"] - state["g"]).max() <= ROUNDING
        assert np.abs(L[:, 0] - state["path_length"]).max() <= ROUNDING
        assert np.abs(R - state["R"]).max() <= ROUNDING


@pytest.mark.parametrize("name", ["joints.osim", "joints_30000.osim"])
def test_joints_of_all_classes_move_as_in_opensim(name: str, tmp_path: Path) -> None:
    """Frames on frames, constant rotations and shifts, locked coordinates; in the form of two versions."""
    model = every_joint(name, tmp_path)
    of_opensim = json.loads((DATA / "joints.json").read_text())[name]
    mechanism = mechanism_from(model, name)
    coordinates = [model.tree.joints[joint].alias for joint in model.tree.coordinates]
    assert sorted(coordinates) == sorted(of_opensim["coordinates"])
    order = [of_opensim["coordinates"].index(coordinate) for coordinate in coordinates]
    skeleton = Skeleton(mechanism)
    for state in of_opensim["states"]:
        M, h, *_ = skeleton(*([state[of][name] for name in coordinates] for of in ("q", "dq")))
        assert np.abs(M - np.array(state["M"])[np.ix_(order, order)]).max() <= ROUNDING
        assert np.abs(h[:, 0] - (np.array(state["c"]) + state["g"])[order]).max() <= ROUNDING


def every_joint(name: str, folder: Path) -> OpenSimModel:
    """The model with a joint of each class; an older one has no polynomials, but a file of paths beside it."""
    if name == "joints.osim":
        return read_model(DATA / name)
    path = re.search("<FunctionBasedPath.*?</FunctionBasedPath>", (DATA / "joints.osim").read_text())
    assert path is not None
    named = path[0].replace('name="path"', 'name="/forceset/M"')
    (folder / "paths.xml").write_text(
        f"<OpenSimDocument><Set_FunctionBasedPath_><objects>{named}</objects></Set_FunctionBasedPath_></OpenSimDocument>"
    )
    return read_model(DATA / name, folder / "paths.xml")


def test_springs_of_a_coordinate_are_one_spring_of_the_joint() -> None:
    joints = read_model(DATA / "joints.osim").tree.joints
    # 3 (q − 0.2) + 1.5 (q + 0.4) = 4.5 (q − 0)
    assert joints["pin"].stiffness == 4.5
    assert abs(joints["pin"].rest) <= ROUNDING
    assert joints["pin"].damping == 0.5
    assert (joints["rail"].stiffness, joints["rail"].rest, joints["rail"].damping) == (40.0, 0.1, 2.0)


NUMBER = st.floats(-1.5, 1.5)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER).filter(lambda vector: np.linalg.norm(vector) > 0.1)


@given(st.lists(VECTOR, min_size=6, max_size=6), st.lists(NUMBER, min_size=6, max_size=6), st.integers(0, 5), NUMBER)
def test_what_is_constant_in_a_motion_folds_into_the_frames(
    directions: list[tuple[float, float, float]], constants: list[float], moving: int, q: float
) -> None:
    """Trans(Σ t e) Rot(e₁, r₁) Rot(e₂, r₂) Rot(e₃, r₃), which is how the rows of a SpatialTransform are meant."""
    slope = -1.0 if q < 0 else 1.0
    axes = [
        Axis(np.array(direction), *(["q", slope] if number == moving else ["", 0.0]), constant)
        for number, (direction, constant) in enumerate(zip(directions, constants, strict=True))
    ]
    values = [constant + (slope * q if number == moving else 0) for number, constant in enumerate(constants)]
    turned = np.linalg.multi_dot([about(axis.unit, value) for axis, value in zip(axes[:3], values[:3], strict=True)])
    shift = sum(axis.unit * value for axis, value in zip(axes[3:], values[3:], strict=True))
    found = single(Component(Element("CustomJoint")), axes, {})
    assert (found.kind, found.coordinate) == (PIN if moving < 3 else SLIDER, "q")
    parent, child = (
        Fixed("a", (0.1, -0.2, 0.3), (0.4, 0.5, -0.6)).then(extra) for extra in (found.before, found.after)
    )
    direction = np.array(found.axis) / np.linalg.norm(found.axis)
    motion = about(direction, q) if found.kind == PIN else np.eye(3)
    place = np.zeros(3) if found.kind == PIN else direction * q
    base = frame((0.1, -0.2, 0.3), (0.4, 0.5, -0.6))
    at, hung = frame(parent.at, parent.orientation), frame(child.at, child.orientation).inverse()
    # base · motion · base⁻¹ by both ways
    expected = base.turned @ turned @ base.turned.T
    assert np.abs(at.turned @ motion @ hung.turned - expected).max() <= ROUNDING
    expected_at = base.at + base.turned @ shift - expected @ base.at
    assert np.abs(at.at + at.turned @ (place + motion @ hung.at) - expected_at).max() <= ROUNDING


@given(NUMBER, st.floats(-np.pi / 2, np.pi / 2), NUMBER)
def test_angles_of_a_rotation_give_it_again(a: float, b: float, c: float) -> None:
    turned = frame((0, 0, 0), (a, b, c)).turned
    # near a quarter turn about y the cosines are small, and their ratio keeps half of the digits
    assert np.abs(frame((0, 0, 0), angles(turned)).turned - turned).max() <= 1e-7


def test_a_locked_joint_stays_in_the_lengths() -> None:
    free, locked = polynomial_arm(), polynomial_arm(locks={"shoulder": -0.1})
    assert locked.tree.coordinates == ("elbow",)
    assert locked.tree.joints["shoulder"].locked == -0.1
    assert locked.paths["BIClong"].joints == ("elbow",)
    for elbow in (0.2, 1.1, 2.0):
        there = lengths(locked, elbow=elbow)
        for name, length in lengths(free, shoulder=-0.1, elbow=elbow).items():
            assert there[name] == pytest.approx(length, rel=1e-14)


@pytest.mark.parametrize("called", ["shoulder", "r_shoulder", "r_shoulder_elev"])
def test_a_joint_is_locked_by_its_name_here_there_or_by_its_coordinate(called: str) -> None:
    assert polynomial_arm(locks={called: -0.1}) == polynomial_arm(locks={"shoulder": -0.1})


def test_a_range_that_is_given_is_that_of_the_joint() -> None:
    arm = polynomial_arm(ranges={"elbow": (0.1, 2.1)})
    assert arm.tree.joints["elbow"].range == (0.1, 2.1)
    assert arm.tree.joints["shoulder"].range == (-1.57079633, 3.14159265)


def test_chosen_muscles_are_those_of_the_model() -> None:
    two = polynomial_arm(only=["TRIlat", "BRA"])
    assert list(two.muscles) == ["TRIlat", "BRA"]
    assert two.muscles["BRA"] == polynomial_arm().muscles["BRA"]


def test_a_model_is_a_file_of_paths_too() -> None:
    assert read_paths(DATA / "arm26_polynomial.osim") == read_paths(PATHS)
