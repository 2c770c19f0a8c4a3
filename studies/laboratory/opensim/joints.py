"""Joints of a model: pins, sliders and welds, whatever class they have, in the forms of both versions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from ....model.skeleton.tree import WELD, Joint
from ...files.errors import ScenarioError
from ...files.quote import shown
from .document import Component, Document
from .frames import Fixed, Frames, socket, vector
from .motion import motion, single

# rad or m: OpenSim's default range is from −10 to 10, and models without one write such numbers
_NO_RANGE = 10.0
_NOWHERE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Coordinate:
    """A coordinate: its range, where it is at first, and whether it stays there or is moved."""

    name: str
    value: float
    range: tuple[float, float] | None
    locked: bool
    prescribed: bool


@dataclass(frozen=True)
class ReadJoint:
    """A joint as the model has it, its coordinates, and what each socket or older tag leads to."""

    component: Component
    coordinates: tuple[Coordinate, ...]
    parent: Fixed
    child: Fixed

    @property
    def name(self) -> str:
        """As the model has it."""
        return self.component.name

    def held(self, values: Mapping[str, float]) -> Joint:
        """The joint where coordinates are held at these values. ScenarioError if it moves by more than one."""
        names = [coordinate.name for coordinate in self.coordinates]
        # a joint with one coordinate stays a pin or a slider, and says where it is locked
        alone = names if len(names) == 1 else []
        axes = motion(self.component, names)
        left = single(
            self.component, axes, {name: values[name] for name in names if name in values and name not in alone}
        )
        parent, child = self.parent.then(left.before), self.child.then(left.after)
        joint = Joint(
            parent.link,
            child.link,
            left.kind,
            at=parent.at,
            orientation=parent.orientation,
            child_at=child.at,
            child_orientation=child.orientation,
        )
        if left.kind == WELD:
            return joint
        coordinate = next(own for own in self.coordinates if own.name == left.coordinate)
        return replace(
            joint,
            axis=left.axis,
            range=coordinate.range,
            locked=values.get(coordinate.name),
            prescribed=coordinate.prescribed and coordinate.name not in values,
            alias=coordinate.name,
        )


def joints(document: Document, bodies: Mapping[str, Component]) -> list[ReadJoint]:
    """All joints of a model. ScenarioError names one that cannot be, or that holds what another holds."""
    frames = Frames(document, list(bodies))
    found = [_read(document, component, *places) for component, places in _held(document, bodies, frames)]
    names = [joint.name for joint in found]
    coordinates = [coordinate.name for joint in found for coordinate in joint.coordinates]
    for what, of_kind in (("joint", names), ("coordinate", coordinates)):
        if repeated := [name for name in of_kind if of_kind.count(name) > 1]:
            raise ScenarioError(f"has two {what}s called {shown(repeated[0])}")
    return found


def _held(
    document: Document, bodies: Mapping[str, Component], frames: Frames
) -> Iterator[tuple[Component, tuple[Fixed, Fixed]]]:
    """Each joint with its frames on the parent and on the child."""
    for joint in document.members("Joint"):
        yield (
            joint,
            (frames.find(socket(joint, "parent_frame"), joint), frames.find(socket(joint, "child_frame"), joint)),
        )
    # an older version keeps the joint in the body that it holds
    for name, body in bodies.items():
        holder = body.element.child("Joint")
        for element in holder.children if holder else []:
            joint = document.component(element)
            parent = joint.words("parent_body")
            if parent is None:
                raise ScenarioError(f"{joint.where} has no parent_body")
            places = [vector(joint.numbers(tag, 3, _NOWHERE)) for tag in _OLDER]
            yield joint, (Fixed(parent, *places[:2]), Fixed(name, *places[2:]))


_OLDER = ("location_in_parent", "orientation_in_parent", "location", "orientation")


def _read(document: Document, joint: Component, parent: Fixed, child: Fixed) -> ReadJoint:
    if joint.flag("reverse"):
        raise ScenarioError(f"{joint.where}: is reversed, which is not read; exchange its parent and its child")
    own = joint.element.child("coordinates") or joint.element.within("CoordinateSet", "objects")
    coordinates = [_coordinate(document.component(element)) for element in (own.children if own else [])]
    return ReadJoint(joint, tuple(coordinates), parent, child)


def _coordinate(coordinate: Component) -> Coordinate:
    low, high = coordinate.numbers("range", 2, (-_NO_RANGE, _NO_RANGE))
    return Coordinate(
        coordinate.name,
        coordinate.number("default_value", 0.0),
        (low, high) if -_NO_RANGE < low < high < _NO_RANGE else None,
        coordinate.flag("locked"),
        coordinate.flag("prescribed"),
    )
