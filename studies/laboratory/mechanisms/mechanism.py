"""A mechanism in SI: a tree of links and joints, and muscles along paths over the joints."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ....model.skeleton.newton_euler import mass_matrix
from ....model.skeleton.paths import Path
from ....model.skeleton.points import Point
from ....model.skeleton.tree import Tree
from ...files.errors import ScenarioError
from ...files.quote import shown
from ..muscles import Muscle

# signals are named after joints and muscles, and so is what is compiled: as a Block's name, but shorter
_NAME = re.compile(r"(?=.{1,30}$)[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*")


@dataclass(frozen=True)
class Mechanism:
    """kg, m, rad, N; `paths` are the muscles' lengths in m over the coordinates of the tree's joints, by muscle.

    points: places on links, by name, that can follow a reference. description: what results say of it.

    ScenarioError if a path is missing, or crosses a joint that has no coordinate, for a name that is none, or if
    nothing moves, or something without a mass.
    """

    tree: Tree
    muscles: Mapping[str, Muscle]
    paths: Mapping[str, Path]
    description: str = ""
    points: Mapping[str, Point] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.muscles:
            raise ScenarioError("a mechanism needs a muscle or more")
        for name in (*self.tree.coordinates, *self.muscles, *self.points):
            if not is_name(name):
                raise ScenarioError(
                    f"{shown(name)} is no name for a joint, a muscle or a point: letters, digits, single _ between, "
                    "at most 30"
                )
        if not self.tree.coordinates:
            raise ScenarioError("all joints are locked or weld their links: nothing moves that could be estimated")
        if idle := _carries_nothing(self.tree):
            raise ScenarioError(f"joint {idle} moves no mass; give the links beyond it a mass and an inertia")
        if both := [name for name in self.muscles if name in self.tree.coordinates]:
            raise ScenarioError(f"a muscle and a joint are both called {both[0]}")
        for name, point in self.points.items():
            if name in self.tree.coordinates or name in self.muscles:
                raise ScenarioError(f"a point and a joint or muscle are both called {name}")
            if point.link not in self.tree.links:
                raise ScenarioError(
                    f"points.{name}: its link {shown(point.link)} is none; there are {', '.join(self.tree.links)}"
                )
        if missing := [name for name in self.muscles if name not in self.paths]:
            raise ScenarioError(f"muscle {missing[0]} has no path")
        for name, path in self.paths.items():
            if unknown := [joint for joint in path.joints if joint not in self.tree.coordinates]:
                known = ", ".join(self.tree.coordinates) or "none"
                raise ScenarioError(
                    f"muscles.{name}.path crosses {unknown[0]}, which is no moving joint; there are {known}"
                )


def is_name(name: str) -> bool:
    """Whether a joint, a muscle or a point can be called so."""
    return bool(_NAME.fullmatch(name))


def _carries_nothing(tree: Tree) -> str:
    """The first free joint that turns or shifts no mass, in the middle of all ranges; empty if there is none."""
    ranges = {name: tree.joints[name].range for name in tree.coordinates}
    inertias = np.diag(mass_matrix(tree, {name: sum(limits) / 2 if limits else 0.0 for name, limits in ranges.items()}))
    return next((name for name, own in zip(ranges, inertias, strict=True) if name in tree.free and not own > 0), "")
