"""Forces that are no muscles: springs of coordinates become those of joints, all others are named."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from ....model.skeleton.tree import Joint
from ...files.errors import ScenarioError
from ...files.quote import short, shown
from .document import Component, Document, listed

_SPRING = "SpringGeneralizedForce"
_NO_FORCE = {"CoordinateActuator", "TorqueActuator", "PointActuator", "PointToPointActuator", "BodyActuator"}


@dataclass(frozen=True)
class Spring:
    """At a coordinate: −stiffness (q − rest) − damping q̇."""

    coordinate: str
    stiffness: float
    rest: float
    damping: float


def acting(document: Document) -> list[Component]:
    """The forces of a model that are not switched off."""
    return [
        force
        for force in document.members("Force")
        if force.flag("appliesForce", True) and not force.flag("isDisabled")
    ]


def springs(forces: list[Component], coordinates: list[str]) -> list[Spring]:
    """Springs of coordinates. ScenarioError if there is no such coordinate."""
    found = []
    for force in forces:
        if force.element.tag == _SPRING:
            name = (force.words("coordinate") or "").rpartition("/")[2]
            if name not in coordinates:
                raise ScenarioError(f"{force.where}: there is no coordinate {shown(name)}")
            numbers = (force.number(tag, 0.0) for tag in ("stiffness", "rest_length", "viscosity"))
            found.append(Spring(name, *numbers))
    return found


def sprung(joint: Joint, springs: list[Spring]) -> Joint:
    """The joint with the springs of its coordinate, which together are one."""
    own = [spring for spring in springs if spring.coordinate == joint.alias]
    stiffness = sum((spring.stiffness for spring in own), 0.0)
    # Σ k (q − rest) = (Σ k)(q − Σ k rest/Σ k)
    rest = sum(spring.stiffness * spring.rest for spring in own) / stiffness if stiffness else 0.0
    return replace(joint, stiffness=stiffness, rest=rest, damping=sum((spring.damping for spring in own), 0.0))


def left_out(forces: list[Component], muscles: Mapping[str, object]) -> Iterator[str]:
    """A sentence for each kind of force that is not taken and is no muscle."""
    kinds: dict[str, list[str]] = {}
    for force in forces:
        if force.name not in muscles and force.element.tag not in (_SPRING, *_NO_FORCE):
            kinds.setdefault(force.element.tag, []).append(force.name)
    for kind, names in kinds.items():
        yield f"{short(kind)} {listed(map(shown, names))} left out: what they do counts as disturbance"
