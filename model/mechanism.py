"""Joints and muscles of a tree as a System: lengths along paths, accelerations by the equation of motion."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from types import MappingProxyType

import casadi as ca
import numpy as np

from .curves import CurveSet
from .dialect import solved
from .skeleton.newton_euler import equation_of_motion
from .skeleton.paths import Path, moment_arms
from .skeleton.points import Point, position
from .skeleton.tree import PIN, Tree
from .system import Expressions, System

# how far a joint goes that has no range, in rad or reference lengths, and one that turns round and round
_ANYWHERE, _ROUND = 3.0, 1e4
# places along the range of each joint at which muscles are measured
_PLACES = 5


def mechanism_system(
    tree: Tree,
    paths: Mapping[str, Path],
    curves: Mapping[str, CurveSet],
    pennate: frozenset[str] = frozenset(),
    points: Mapping[str, Point] = MappingProxyType({}),
) -> System:
    """The joints of a tree and muscles along `paths`, in the units of these; pennate: muscles with oblique fibres."""
    muscles = tuple(curves)
    laws = _Laws(tree, [paths[muscle] for muscle in muscles])
    reaches = {**_reaches(tree), **{muscle: _longest(tree, paths[muscle]) for muscle in muscles}}
    return System(
        joints=tree.coordinates,
        muscles=muscles,
        curves=curves,
        parameters={},
        lengths=lambda q, p: laws.lengths(q),
        accelerations=lambda q, dq, F, p: laws.accelerations(q, dq, F),
        reach=lambda of, p: reaches[of],
        forces=lambda q, Delta, p: laws.forces(q, Delta),
        pennate=pennate,
        places=lambda q: _places(tree, points, dict(zip(tree.coordinates, q, strict=True))),
    )


def _places(tree: Tree, points: Mapping[str, Point], q: Mapping[str, ca.SX]) -> dict[str, ca.SX]:
    coordinates = {
        f"{name}.{axis}": value
        for name, point in points.items()
        for axis, value in zip("xyz", ca.vertsplit(position(tree, point, q)), strict=True)
    }
    return {**q, **coordinates}


class _Laws:
    """Lengths, accelerations and forces as functions, since the equation of motion takes a while to write down."""

    def __init__(self, tree: Tree, paths: list[Path]) -> None:
        joints = tree.coordinates
        q, dq, Delta = (ca.SX.sym(name, len(joints)) for name in ("q", "dq", "Delta"))
        F = ca.SX.sym("F", len(paths))
        at, speeds = (dict(zip(joints, ca.vertsplit(values), strict=True)) for values in (q, dq))
        L = ca.vertcat(*(path.length(at) for path in paths))
        motion = equation_of_motion(tree, at, speeds)
        free = [joints.index(name) for name in tree.free]
        # M q̈ = R F − h; what is prescribed moves as if it kept its velocity, and Δ of it is its acceleration
        acc, forces = ca.SX(len(joints), 1), ca.SX.nan(len(joints), 1)
        if free:
            acc[free] = solved(motion.M[free, free], (moment_arms(L, q) @ F - motion.h)[free])
            # M_ff Δ_f + M_fp q̈_p: nobody knows the force that moves what is prescribed
            forces[free] = motion.M[free, :] @ Delta
        self._lengths = ca.Function("lengths", [q], [L])
        self._accelerations = ca.Function("accelerations", [q, dq, F], [acc])
        self._forces = ca.Function("forces", [q, Delta], [forces])

    def lengths(self, q: Expressions) -> list[ca.SX]:
        return ca.vertsplit(self._lengths(ca.vertcat(*q)))

    def accelerations(self, q: Expressions, dq: Expressions, F: Expressions) -> list[ca.SX]:
        return ca.vertsplit(self._accelerations(*(ca.vertcat(*values) for values in (q, dq, F))))

    def forces(self, q: Expressions, Delta: Expressions) -> list[ca.SX]:
        return ca.vertsplit(self._forces(ca.vertcat(*q), ca.vertcat(*Delta)))


def _ranges(tree: Tree) -> list[tuple[float, float]]:
    return [tree.joints[name].range or (-_ANYWHERE, _ANYWHERE) for name in tree.coordinates]


def _reaches(tree: Tree) -> dict[str, float]:
    """How far each joint can be from 0."""
    largest = (max(map(abs, limits)) for limits in _ranges(tree))
    return {
        name: most if tree.joints[name].kind != PIN else max(most, _ANYWHERE) if tree.joints[name].range else _ROUND
        for name, most in zip(tree.coordinates, largest, strict=True)
    }


def _longest(tree: Tree, path: Path) -> float:
    """The length of a muscle where it is longest within the ranges of the joints that it crosses."""
    q, ranges = ca.SX.sym("q", len(path.joints)), dict(zip(tree.coordinates, _ranges(tree), strict=True))
    length = path.length(dict(zip(path.joints, ca.vertsplit(q), strict=True)))
    along = [np.linspace(*ranges[joint], _PLACES) for joint in path.joints]
    places = np.array(list(itertools.product(*along)))
    return float(np.abs(np.array(ca.Function("length", [q], [length])(places.T), dtype=float)).max())
