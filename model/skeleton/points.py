"""Where a point of a link is, as the joints move it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ..arrays import Array
from .bodies import bodies, place_of
from .frames import symbolic_about
from .tree import Tree, Vector


@dataclass(frozen=True)
class Point:
    """A place, `at` m in the frame of a link, such as that of a hand."""

    link: str
    at: Vector

    def scaled(self, length: float) -> Point:
        """The same with lengths in this unit."""
        x, y, z = self.at
        return Point(self.link, (x / length, y / length, z / length))


def position(tree: Tree, point: Point, q: Mapping[str, ca.SX]) -> ca.SX:
    """Where the point is in the ground's frame (3 × 1), at coordinates q by the joint's name."""
    chain, place = bodies(tree), place_of(tree, point.link)
    at = _dense(place.frame.turned @ np.array(point.at) + place.frame.at)
    number = place.body
    # from the body that carries it inwards: x ↦ turned x + at
    while number >= 0:
        body = chain[number]
        turned, origin = ca.SX(ca.DM(body.joint.turned)), _dense(body.joint.at)
        coordinate = q[body.name]
        moved = at + _dense(body.axis) * coordinate if body.slides else symbolic_about(body.axis, coordinate) @ at
        at, number = turned @ moved + origin, body.parent
    return ca.densify(at)


def _dense(vector: Array) -> ca.SX:
    return ca.SX(ca.DM(vector))
