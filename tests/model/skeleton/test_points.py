"""Where points of links are, against homogeneous matrices multiplied out from the file's numbers."""

import casadi as ca
import numpy as np
import pytest

from hillobs.model.arrays import Array
from hillobs.model.skeleton.points import Point, position
from hillobs.model.skeleton.tree import Joint, Link, Tree
from hillobs.studies.laboratory.mechanisms.reading import read_mechanism
from places import RECORDINGS

RNG = np.random.default_rng(5)


def turn(axis: Array, angle: float) -> Array:
    """The rotation (4 × 4) of a point about an axis: its part along the axis, and the rest turned."""
    e = np.asarray(axis) / np.linalg.norm(axis)
    matrix = np.eye(4)
    for i, unit in enumerate(np.eye(3)):
        along = e * (e @ unit)
        matrix[:3, i] = along + np.cos(angle) * (unit - along) + np.sin(angle) * np.cross(e, unit)
    return matrix


def shift(by: Array) -> Array:
    """The translation (4 × 4)."""
    matrix = np.eye(4)
    matrix[:3, 3] = by
    return matrix


def placed(at: Array, angles: Array) -> Array:
    """A frame (4 × 4) at a place, turned about its own x, y, z."""
    turned = np.eye(4)
    for axis, angle in zip(np.eye(3), angles, strict=True):
        turned = turned @ turn(axis, angle)
    return shift(at) @ turned


def by_matrices(tree: Tree, point: Point, q: dict[str, float]) -> Array:
    """The point (3) in the ground, joint by joint from its link inwards."""
    x, link = np.array([*point.at, 1.0]), point.link
    while link != "ground":
        name, joint = next((name, joint) for name, joint in tree.joints.items() if joint.child == link)
        moved = np.eye(4)
        if joint.kind != "weld":
            by = q.get(name, joint.locked or 0.0)
            e = np.array(joint.axis) / np.linalg.norm(joint.axis)
            moved = shift(by * e) if joint.kind == "slider" else turn(e, by)
        inner = np.linalg.inv(placed(joint.child_at, joint.child_orientation))
        x, link = placed(joint.at, joint.orientation) @ moved @ inner @ x, joint.parent
    return np.asarray(x[:3])


def evaluated(tree: Tree, point: Point, q: dict[str, float]) -> Array:
    """Ours (3)."""
    return np.array(ca.evalf(position(tree, point, {name: ca.SX(value) for name, value in q.items()}))).ravel()


def test_the_hand_of_the_arm_is_where_matrices_put_it() -> None:
    arm = read_mechanism(RECORDINGS / "arm.toml")
    for _ in range(10):
        q = dict(zip(arm.tree.coordinates, RNG.uniform(-1, 2, 2), strict=True))
        where = evaluated(arm.tree, arm.points["hand"], q)
        np.testing.assert_allclose(where, by_matrices(arm.tree, arm.points["hand"], q), atol=1e-14)


def draw() -> tuple[float, float, float]:
    """Three numbers within ±1."""
    x, y, z = RNG.uniform(-1, 1, 3).tolist()
    return x, y, z


@pytest.mark.parametrize("locked", [None, 0.3])
def test_turned_frames_sliders_and_locked_joints_carry_a_point(locked: float | None) -> None:
    frames = [{"at": draw(), "orientation": draw(), "child_at": draw(), "child_orientation": draw()} for _ in range(3)]
    joints = {
        "turns": Joint("ground", "a", "pin", draw(), **frames[0]),
        "slides": Joint("a", "b", "slider", draw(), **frames[1], locked=locked),
        "again": Joint("b", "c", "pin", draw(), **frames[2]),
    }
    tree, point = Tree({name: Link(1.0) for name in "abc"}, joints), Point("c", draw())
    q = {name: float(value) for name, value in zip(tree.coordinates, RNG.uniform(-2, 2, 3), strict=False)}
    # a few metres, and the rounding of a dozen products
    np.testing.assert_allclose(evaluated(tree, point, q), by_matrices(tree, point, q), atol=1e-13)


def test_a_point_scales_with_its_tree() -> None:
    arm = read_mechanism(RECORDINGS / "arm.toml")
    q, unit = {"shoulder": -0.3, "elbow": 1.1}, 0.134
    scaled = evaluated(arm.tree.scaled(unit, 2.0, 3.0), arm.points["hand"].scaled(unit), q)
    np.testing.assert_allclose(scaled * unit, evaluated(arm.tree, arm.points["hand"], q), atol=1e-14)
