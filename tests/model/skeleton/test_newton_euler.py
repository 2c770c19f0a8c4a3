"""The equation of motion of trees: against textbooks, and what mechanics says of every tree."""

import dataclasses
import itertools

import casadi as ca
import numpy as np
import pytest

from hillobs.model.skeleton.frames import about, frame
from hillobs.model.skeleton.newton_euler import equation_of_motion
from hillobs.model.skeleton.tree import GROUND, PIN, SLIDER, WELD, Joint, Link, Tree

DOWN = (0.0, -9.81, 0.0)
ROD = Link(1.3, (0.02, -0.21, 0.01), (0.03, 0.004, 0.028, 0.001, -0.002, 0.0005))
FORE = Link(0.8, (-0.01, -0.17, 0.005), (0.012, 0.002, 0.011, -0.0003, 0.0002, 0.0004))
# a pin, a slider askew, another pin
ARM = Tree(
    {"upper": ROD, "sleeve": Link(0.2, (0.01, 0.0, 0.0), (1e-3, 1e-3, 1e-3, 0, 0, 0)), "lower": FORE},
    {
        "shoulder": Joint(GROUND, "upper", PIN, (0.1, -0.2, 1.0), (0.0, 0.8, 0.1), (0.2, 0.1, -0.3)),
        "reach": Joint("upper", "sleeve", SLIDER, (0.3, -1.0, 0.2), (0.0, -0.3, 0.0), child_orientation=(0.1, 0, 0)),
        "elbow": Joint("sleeve", "lower", PIN, (0.0, 0.4, 1.0), child_at=(0.0, 0.05, 0.0)),
    },
    DOWN,
)


class Numbers:
    """M and h of a tree as functions of numbers."""

    def __init__(self, tree: Tree) -> None:
        self.names = tree.coordinates
        q, dq = ({name: ca.SX.sym(name) for name in self.names} for _ in range(2))
        motion = equation_of_motion(tree, q, dq)
        self._compute = ca.Function("motion", [ca.vertcat(*q.values()), ca.vertcat(*dq.values())], [motion.M, motion.h])

    def M(self, q):
        return np.array(self._compute(q, np.zeros(len(self.names)))[0])

    def h(self, q, dq):
        return np.array(self._compute(q, dq)[1])[:, 0]


def states(n, count=10):
    random = np.random.default_rng(1)
    return [(random.uniform(-1, 1, n), random.uniform(-3, 3, n)) for _ in range(count)]


def largest(difference):
    return float(np.abs(difference).max())


# a few hundred operations on numbers of order 1 to 10
ROUNDING = 1e-12


def test_two_pins_in_a_plane_are_the_double_pendulum_of_the_textbooks() -> None:
    m1, m2, l1, r1, r2, J1, J2, g = 1.3, 0.8, 0.4, 0.21, 0.17, 0.028, 0.011, 9.81
    tree = Tree(
        {"a": Link(m1, (0, -r1, 0), (0, J1, J1, 0, 0, 0)), "b": Link(m2, (0, -r2, 0), (0, J2, J2, 0, 0, 0))},
        {"first": Joint(GROUND, "a"), "second": Joint("a", "b", at=(0, -l1, 0))},
        DOWN,
    )
    motion = Numbers(tree)
    for (q1, q2), (w1, w2) in states(2):
        coupling, both = m2 * l1 * r2 * np.cos(q2), J2 + m2 * r2**2
        M = [[J1 + m1 * r1**2 + m2 * l1**2 + both + 2 * coupling, both + coupling], [both + coupling, both]]
        s, low = m2 * l1 * r2 * np.sin(q2), m2 * g * r2 * np.sin(q1 + q2)
        h = [-s * (2 * w1 * w2 + w2**2) + (m1 * r1 + m2 * l1) * g * np.sin(q1) + low, s * w1**2 + low]
        assert largest(motion.M([q1, q2]) - M) < ROUNDING
        assert largest(motion.h([q1, q2], [w1, w2]) - h) < ROUNDING


def test_M_is_symmetric_and_positive_and_makes_the_kinetic_energy() -> None:
    motion = Numbers(ARM)
    for q, dq in states(3):
        M = motion.M(q)
        assert largest(M - M.T) < ROUNDING
        assert np.linalg.eigvalsh(M).min() > 0
        # ½ q̇ᵀM q̇ against ½ m|v|² + ½ ωᵀIω, by differences of where the bodies are
        assert dq @ M @ dq / 2 == pytest.approx(kinetic_energy(q, dq), rel=1e-7)


def kinetic_energy(q, dq, step=1e-6):
    """Of ARM, from places and rotations a little before and after."""
    total = 0.0
    for link, (now, before, after) in zip(
        ARM.links.values(), zip(*(where(q + s * step * dq) for s in (0, -1, 1)), strict=True), strict=True
    ):
        centre = [turned @ np.array(link.com) + at for turned, at in (before, after)]
        v = (centre[1] - centre[0]) / (2 * step)
        spin = now[0].T @ (after[0] - before[0]) / (2 * step)  # K with K x = ω × x, in the link's frame
        omega = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        total += link.mass * v @ v / 2 + omega @ link.tensor @ omega / 2
    return total


def where(q):
    """Rotation and place of each link of ARM: along the joints, without any folding."""
    turned, at, found = np.eye(3), np.zeros(3), []
    for joint, value in zip(ARM.joints.values(), q, strict=True):
        axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
        slides = joint.kind == SLIDER
        steps = [
            frame(joint.at, joint.orientation),
            frame(tuple(value * axis) if slides else (0, 0, 0), (0, 0, 0)),
        ]
        for step in steps:
            at, turned = at + turned @ step.at, turned @ step.turned
        if not slides:
            turned = turned @ about(axis, value)
        child = frame(joint.child_at, joint.child_orientation)
        turned = turned @ child.turned.T
        at = at - turned @ child.at
        found.append((turned, at))
    return found


def test_without_forces_energy_stays() -> None:
    """d/dt(½ q̇ᵀM q̇) = ½ q̇ᵀṀ q̇ + q̇ᵀM q̈ = −q̇ᵀ∂V/∂q: with M q̈ = −h the velocities' part of h does no work."""
    motion, step = Numbers(ARM), 1e-6
    for q, dq in states(3):
        M_dot = (motion.M(q + step * dq) - motion.M(q - step * dq)) / (2 * step)
        gravity = motion.h(q, np.zeros(3))
        power = dq @ M_dot @ dq / 2 - dq @ (motion.h(q, dq) - gravity)
        assert abs(power) < 1e-7 * abs(dq @ M_dot @ dq)


def test_gravity_is_the_gradient_of_height() -> None:
    motion, step = Numbers(ARM), 1e-6

    def potential(q):
        return sum(
            -link.mass * np.array(DOWN) @ (turned @ np.array(link.com) + at)
            for link, (turned, at) in zip(ARM.links.values(), where(q), strict=True)
        )

    for q, _ in states(3):
        slope = [(potential(q + step * e) - potential(q - step * e)) / (2 * step) for e in np.eye(3)]
        assert motion.h(q, np.zeros(3)) == pytest.approx(np.array(slope), abs=1e-8)


@pytest.mark.parametrize("joint", ARM.joints)
def test_a_locked_joint_is_a_weld_there_and_all_others_move_as_before(joint: str) -> None:
    value, places = 0.4, [i for i, name in enumerate(ARM.coordinates) if name != joint]
    locked = dataclasses.replace(ARM.joints[joint], locked=value)
    before, after = Numbers(ARM), Numbers(dataclasses.replace(ARM, joints={**ARM.joints, joint: locked}))
    for q, dq in states(3):
        q[ARM.coordinates.index(joint)], dq[ARM.coordinates.index(joint)] = value, 0
        assert largest(before.M(q)[np.ix_(places, places)] - after.M(q[places])) < ROUNDING
        assert largest(before.h(q, dq)[places] - after.h(q[places], dq[places])) < ROUNDING


def test_where_frames_are_put_and_how_bodies_are_cut_does_not_matter() -> None:
    motion = Numbers(ARM)
    # the lower link as two halves, welded at a place and turned
    at, turn = (0.03, -0.1, 0.02), (0.5, -0.4, 0.3)
    R = frame(at, turn).turned
    half = Link(
        FORE.mass / 2, tuple(R.T @ (np.array(FORE.com) - at)),
        tuple((R.T @ FORE.tensor @ R / 2)[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))),
    )  # fmt: skip
    kept = Link(FORE.mass / 2, FORE.com, tuple(np.array(FORE.inertia) / 2))
    cut = Tree(
        {**ARM.links, "lower": kept, "half": half},
        {**ARM.joints, "cut": Joint("lower", "half", WELD, at=at, orientation=turn)},
        DOWN,
    )
    other = Numbers(cut)
    # all of it below a turned base, gravity turned with it
    base = frame((1.0, 2.0, 3.0), (0.3, 0.2, 0.1))
    moved = Tree(
        {**ARM.links, "base": Link()},
        {
            "foot": Joint(GROUND, "base", WELD, at=(1.0, 2.0, 3.0), orientation=(0.3, 0.2, 0.1)),
            **{**ARM.joints, "shoulder": dataclasses.replace(ARM.joints["shoulder"], parent="base")},
        },
        tuple(base.turned @ np.array(DOWN)),
    )
    elsewhere = Numbers(moved)
    for q, dq in states(3):
        for same in (other, elsewhere):
            assert largest(motion.M(q) - same.M(q)) < ROUNDING
            assert largest(motion.h(q, dq) - same.h(q, dq)) < ROUNDING


def test_other_units_move_alike() -> None:
    """With units l, m and 1/r: M of two pins is over m l², a slider's over m, h the same times r²."""
    length, mass, rate = 0.1, 20.0, 7.0
    held = {"reach": {"stiffness": 30.0, "rest": 0.1, "damping": 2.0}, "elbow": {"stiffness": 3.0, "rest": 0.2}}
    joints = {name: dataclasses.replace(joint, **held.get(name, {})) for name, joint in ARM.joints.items()}
    tree = dataclasses.replace(ARM, joints=joints)
    units = np.array([length if tree.joints[name].kind == SLIDER else 1.0 for name in tree.coordinates])
    ours, theirs = Numbers(tree), Numbers(tree.scaled(length, mass, rate))
    for q, dq in states(3):
        torque = mass * length**2 * rate**2 / units
        scaled = theirs.M(q / units) * np.outer(1 / units, 1 / units) * mass * length**2
        assert largest(scaled - ours.M(q)) < ROUNDING
        assert theirs.h(q / units, dq / units / rate) * torque == pytest.approx(ours.h(q, dq), rel=1e-10)


@pytest.mark.parametrize("order", list(itertools.permutations(ARM.joints)))
def test_the_order_of_the_description_does_not_matter(order: tuple[str, ...]) -> None:
    shuffled = dataclasses.replace(ARM, joints={name: ARM.joints[name] for name in order})
    places = [order.index(name) for name in ARM.coordinates]
    q, dq = states(3)[0]
    mixed = np.empty(3), np.empty(3)
    for of, values in zip(mixed, (q, dq), strict=True):
        of[places] = values
    found = Numbers(shuffled).h(*mixed)
    assert largest(found[places] - Numbers(ARM).h(q, dq)) < ROUNDING
