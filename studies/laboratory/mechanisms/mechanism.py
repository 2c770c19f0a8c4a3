"""A mechanism in SI: a tree of links and joints, and muscles along paths over the joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ....model.skeleton.paths import Path
from ....model.skeleton.tree import Tree
from ...files.errors import ScenarioError
from ..muscles import Muscle


@dataclass(frozen=True)
class Mechanism:
    """kg, m, rad, N; `paths` are the muscles' lengths in m over the coordinates of the tree's joints, by muscle.

    ScenarioError if a path is missing, or crosses a joint that has no coordinate.
    """

    tree: Tree
    muscles: Mapping[str, Muscle]
    paths: Mapping[str, Path]
    description: str = ""

    def __post_init__(self) -> None:
        if not self.muscles:
            raise ScenarioError("a mechanism needs a muscle or more")
        if missing := [name for name in self.muscles if name not in self.paths]:
            raise ScenarioError(f"muscle {missing[0]} has no path")
        for name, path in self.paths.items():
            if unknown := [joint for joint in path.joints if joint not in self.tree.coordinates]:
                known = ", ".join(self.tree.coordinates) or "none"
                raise ScenarioError(
                    f"muscles.{name}.path crosses {unknown[0]}, which is no moving joint; there are {known}"
                )
