"""Frames: where one is in another, as numbers, and the rotation of a joint, as an expression."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import casadi as ca
import numpy as np

from ..arrays import Array

Q = TypeVar("Q", ca.SX, Array)

# the sine and cosine of a right angle are 0 and 1 but for rounding, and 0 costs nothing
_ROUNDING = 1e-15


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame in another one: x ↦ turned x + at."""

    turned: Array  # 3 × 3
    at: Array  # 3

    def within(self, outer: Frame) -> Frame:
        """The same frame, which is given in `outer`, in what that is given in."""
        return Frame(_clean(outer.turned @ self.turned), outer.turned @ self.at + outer.at)

    def inverse(self) -> Frame:
        """The other frame in this one."""
        return Frame(self.turned.T, -self.turned.T @ self.at)


HERE = Frame(np.eye(3), np.zeros(3))


def frame(at: tuple[float, float, float], orientation: tuple[float, float, float]) -> Frame:
    """At a place, turned about its own x, then its own y, then its own z, in rad."""
    turned = np.eye(3)
    for axis, angle in zip(np.eye(3), orientation, strict=True):
        turned = turned @ about(axis, angle)
    return Frame(_clean(turned), np.array(at, dtype=float))


def about(axis: Array, angle: float) -> Array:
    """The rotation (3 × 3) by an angle in rad about an axis of length 1."""
    # R = I + sin q K + (1 − cos q) K²,  K v = e × v   (Rodrigues)
    K = cross(axis)
    return _clean(np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K)


def symbolic_about(axis: Array, angle: ca.SX) -> ca.SX:
    """The same, of an angle that is an expression."""
    K = cross(axis)
    return ca.SX(ca.DM(_clean(np.eye(3) + K @ K))) + ca.sin(angle) * _sparse(K) - ca.cos(angle) * _sparse(K @ K)


def cross(vector: Array) -> Array:
    """K with K v = vector × v."""
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def _sparse(matrix: Array) -> ca.SX:
    return ca.SX(ca.sparsify(ca.DM(_clean(matrix))))


def _clean(turned: Array) -> Array:
    return np.where(abs(turned) < _ROUNDING, 0.0, turned)
