"""How a joint moves: three rotations, then three shifts, each along an axis by a straight line of a coordinate.

The child's frame is at Trans(Σ t_i e_i) Rot(e₁, r₁) Rot(e₂, r₂) Rot(e₃, r₃) of the parent's; OpenSim's joint classes
are these with fixed axes, and a CustomJoint gives its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ....model.arrays import Array
from ....model.skeleton.frames import HERE, Frame, about
from ....model.skeleton.tree import PIN, SLIDER, WELD
from ...files.errors import ScenarioError
from ...files.quote import short
from .document import Component, listed
from .xml import Element

_CUSTOM = "CustomJoint"
_AXES = np.eye(3)
# class → the rotations and the shifts by its coordinates, in their order: rx is the one about x
_CLASSES: Mapping[str, tuple[str, ...]] = {
    "WeldJoint": (),
    "PinJoint": ("rz",),
    "SliderJoint": ("tx",),
    "UniversalJoint": ("rx", "ry"),
    "PlanarJoint": ("rz", "tx", "ty"),
    "BallJoint": ("rx", "ry", "rz"),
    "GimbalJoint": ("rx", "ry", "rz"),
    "FreeJoint": ("rx", "ry", "rz", "tx", "ty", "tz"),
}
_PLACES = ("rx", "ry", "rz", "tx", "ty", "tz")
_TRANSFORM_AXES = ("rotation1", "rotation2", "rotation3", "translation1", "translation2", "translation3")


@dataclass(frozen=True, eq=False)
class Axis:
    """An angle about an axis of any length, or a shift along it: slope · coordinate + constant."""

    direction: Array
    coordinate: str = ""
    slope: float = 0.0
    constant: float = 0.0

    def held(self, values: Mapping[str, float]) -> Axis:
        """The same, where coordinates are held at these values."""
        if self.coordinate not in values:
            return self
        return Axis(self.direction, constant=self.constant + self.slope * values[self.coordinate])

    @property
    def unit(self) -> Array:
        """The direction, of length 1."""
        return self.direction / float(np.linalg.norm(self.direction))


@dataclass(frozen=True, eq=False)
class Single:
    """What is left of a motion with a coordinate at most: its frames in those of the parent and the child."""

    kind: str
    coordinate: str
    axis: tuple[float, float, float]
    before: Frame
    after: Frame


def motion(joint: Component, coordinates: list[str]) -> list[Axis]:
    """Three rotations and three shifts. ScenarioError names a class or a function that is not known."""
    kind = joint.element.tag
    if kind == _CUSTOM:
        return _custom(joint, coordinates)
    if kind not in _CLASSES:
        raise ScenarioError(
            f"{joint.where}: joints of this class are not read; there are {', '.join(_CLASSES)}, {_CUSTOM}"
        )
    places = _CLASSES[kind]
    if len(coordinates) != len(places):
        raise ScenarioError(f"{joint.where}: must have {len(places)} coordinates, not {len(coordinates)}")
    moved = dict(zip(places, coordinates, strict=True))
    return [
        Axis(_AXES[number % 3], moved.get(place, ""), float(place in moved)) for number, place in enumerate(_PLACES)
    ]


def single(joint: Component, axes: list[Axis], held: Mapping[str, float]) -> Single:
    """The motion where some coordinates are held. ScenarioError if it is more than a pin or a slider."""
    axes = [axis.held(held) for axis in axes]
    moving = [number for number, axis in enumerate(axes) if axis.slope]
    if len(moving) > 1:
        names = list(dict.fromkeys(axes[number].coordinate for number in moving))
        if len(names) == 1:
            raise ScenarioError(
                f"{joint.where}: {names[0]} moves it along {len(moving)} axes; only pins and sliders are read"
            )
        raise ScenarioError(
            f"{joint.where}: has {len(names)} free coordinates, {listed(names)}; only pins and sliders are read: "
            f"lock all but one, such as with --lock {names[-1]}=…"
        )
    shift = sum((axis.constant * axis.unit for axis in axes[3:]), np.zeros(3))
    if not moving:
        return Single(WELD, "", (0.0, 0.0, 1.0), Frame(_turned(axes[:3]), shift), HERE)
    number = moving[0]
    axis = axes[number]
    if abs(axis.slope) != 1:
        raise ScenarioError(
            f"{joint.where}: moves by {axis.slope:g} times its coordinate {axis.coordinate}; only 1 and -1 are read"
        )
    x, y, z = (float(number) for number in axis.slope * axis.direction)
    if number >= len(_AXES):
        after = Frame(_turned(axes[:3]), np.zeros(3))
        return Single(SLIDER, axis.coordinate, (x, y, z), Frame(np.eye(3), shift), after.inverse())
    # Rot(e, ±q + b) = Rot(e, b) Rot(±e, q)
    before = Frame(_turned(axes[: number + 1]), shift)
    after = Frame(_turned(axes[number + 1 : 3]), np.zeros(3))
    return Single(PIN, axis.coordinate, (x, y, z), before, after.inverse())


def _turned(rotations: list[Axis]) -> Array:
    """The constant parts of rotations, one after the other."""
    turned = np.eye(3)
    for axis in rotations:
        turned = turned @ about(axis.unit, axis.constant)
    return turned


def _custom(joint: Component, coordinates: list[str]) -> list[Axis]:
    transform = joint.child("SpatialTransform")
    if transform is None:
        raise ScenarioError(f"{joint.where} has no SpatialTransform")
    given = {axis.name: axis for axis in transform.children if axis.tag == "TransformAxis"}
    return [
        _transform_axis(joint, Component(given[name]), coordinates) if name in given else Axis(_AXES[number % 3])
        for number, name in enumerate(_TRANSFORM_AXES)
    ]


def _transform_axis(joint: Component, axis: Component, coordinates: list[str]) -> Axis:
    direction = np.array(axis.numbers("axis", 3))
    where = f"{joint.where}: {axis.name}"
    if not direction.any():
        raise ScenarioError(f"{where}: its axis is 0 0 0, which has no direction")
    slope, constant = _line(where, _function(axis.element))
    names = (axis.words("coordinates") or "").split()
    if not slope:
        return Axis(direction, constant=constant)
    if len(names) != 1 or names[0] not in coordinates:
        raise ScenarioError(f"{where}: must have one of the joint's coordinates, {listed(coordinates) or 'none'}")
    return Axis(direction, names[0], slope, constant)


def _function(axis: Element) -> Element | None:
    """The function of a TransformAxis, in the form of either version."""
    wrapper = axis.child("function")
    functions = wrapper.children if wrapper else [child for child in axis.children if child.name == "function"]
    return functions[0] if functions else None


def _line(where: str, function: Element | None) -> tuple[float, float]:
    """Slope and constant of a function. ScenarioError if it is no straight line."""
    if function is None:
        return 0.0, 0.0
    own, inner = Component(function), function.child("function")
    match function.tag:
        case "Constant":
            return 0.0, own.number("value", 0.0)
        case "LinearFunction":
            slope, constant = own.numbers("coefficients", 2, (1.0, 0.0))
            return slope, constant
        case "MultiplierFunction":
            scale = own.number("scale", 1.0)
            slope, constant = _line(where, inner.children[0] if inner and inner.children else None)
            return scale * slope, scale * constant
    raise ScenarioError(
        f"{where}: its function is a {short(function.tag)}; only a Constant or a LinearFunction is read"
    )
