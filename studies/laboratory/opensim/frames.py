"""Frames of bodies: each is fixed to a body by a shift and three angles, perhaps by way of other frames."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ....model.arrays import Array
from ....model.skeleton.frames import Frame, frame
from ....model.skeleton.tree import GROUND, Vector
from ...files.errors import ScenarioError
from ...files.quote import shown
from .document import Component, Document

_OFFSET = "PhysicalOffsetFrame"
_NO_ANGLES = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Fixed:
    """Where a frame is on a link: a place, and angles about its own x, y, z one after the other."""

    link: str
    at: Vector = (0.0, 0.0, 0.0)
    orientation: Vector = _NO_ANGLES

    def then(self, further: Frame) -> Fixed:
        """A frame that is given in this one; numbers stay as they are where it adds nothing."""
        at, turned = self.at, self.orientation
        if not np.array_equal(further.turned, np.eye(3)):
            turned = angles(further.within(frame(self.at, self.orientation)).turned)
        if further.at.any():
            at = vector(frame(self.at, self.orientation).turned @ further.at + np.array(self.at))
        return Fixed(self.link, at, turned)


class Frames:
    """The frames of a document by name, those of a joint before others."""

    def __init__(self, document: Document, links: list[str]) -> None:
        """Of the document, with the names of its bodies."""
        self._links = links
        self._frames: dict[tuple[str, str], Component] = {}
        for owner in document.model.walk():
            for holder in owner.children:
                for child in holder.children if holder.tag in ("frames", "components") else []:
                    if child.tag == _OFFSET:
                        self._frames[owner.name, child.name] = document.component(child)

    def find(self, path: str, owner: Component, seen: tuple[str, ...] = ()) -> Fixed:
        """The frame that a socket of `owner` names. ScenarioError if there is none."""
        holder, _, name = path.strip("./").rpartition("/")
        holder = holder.rpartition("/")[2]
        offset = self._frames.get((holder or owner.name, name))
        if offset is None and name in (GROUND, *self._links):
            return Fixed(name)
        if offset is None:
            offset = next((frame for (_, other), frame in self._frames.items() if other == name), None)
        if offset is None or path in seen:
            raise ScenarioError(f"{owner.where}: there is no frame {shown(path)}")
        parent = socket(offset, "parent")
        at, orientation = (vector(offset.numbers(tag, 3, _NO_ANGLES)) for tag in ("translation", "orientation"))
        base = self.find(parent, owner, (*seen, path))
        if base.at == base.orientation == _NO_ANGLES:
            return Fixed(base.link, at, orientation)
        return base.then(frame(at, orientation))


def socket(component: Component, name: str) -> str:
    """The path that a socket has. ScenarioError if it is missing."""
    words = component.words(f"socket_{name}") or component.words(f"socket_{name}_connectee_name")
    if words is None:
        raise ScenarioError(f"{component.where} has no socket_{name}")
    return words


def vector(numbers: Array | list[float]) -> Vector:
    """Three numbers as a tuple."""
    x, y, z = map(float, numbers)
    return x, y, z


def angles(turned: Array) -> Vector:
    """The angles about its own x, y, z that turn a frame so (3 × 3)."""
    # R₁₃ = sin b, R₂₃ = −sin a cos b, R₃₃ = cos a cos b, R₁₂ = −cos b sin c, R₁₁ = cos b cos c
    across = math.hypot(turned[0, 0], turned[0, 1])
    b = math.atan2(turned[0, 2], across)
    if across < 1e-12:
        # x and z are one axis: all of it is a
        return math.atan2(turned[2, 1], turned[1, 1]), b, 0.0
    return math.atan2(-turned[1, 2], turned[2, 2]), b, math.atan2(-turned[0, 1], turned[0, 0])
