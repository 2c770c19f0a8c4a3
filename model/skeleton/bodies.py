"""A tree with its constant frames folded: one body per moving joint, with all that is welded or locked to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from .frames import HERE, Frame, about, cross, frame
from .tree import GROUND, SLIDER, Joint, Link, Tree

# the body that does not move
_STILL = -1


@dataclass(frozen=True, eq=False)
class Body:
    """What moves with a joint, in the frame of the joint.

    parent: the place of the body that carries it in the list, −1 for none; joint: the frame in that one where the
    coordinate is 0; axis: of length 1; com (3), and inertia (3 × 3) about that.
    """

    name: str
    parent: int
    joint: Frame
    axis: Array
    slides: bool
    mass: float
    com: Array
    inertia: Array


@dataclass(frozen=True, eq=False)
class Place:
    """Where a link is: the number of its body, −1 for the ground, and its frame there."""

    body: int
    frame: Frame


def bodies(tree: Tree) -> list[Body]:
    """The bodies, each after the one that carries it."""
    joints, places = _folded(tree)
    carried = [_together(tree.links, places, number) for number in range(len(joints))]
    return [
        Body(name, parent, fixed, _direction(joint), joint.kind == SLIDER, *of)
        for (name, parent, fixed, joint), of in zip(joints, carried, strict=True)
    ]


def place_of(tree: Tree, link: str) -> Place:
    """Where a link of the tree is."""
    return _folded(tree)[1][link]


def _folded(tree: Tree) -> tuple[list[tuple[str, int, Frame, Joint]], dict[str, Place]]:
    """Each moving joint with the body that carries it and where it is there, and where all links are."""
    places = {GROUND: Place(_STILL, HERE)}
    joints: list[tuple[str, int, Frame, Joint]] = []
    for name in tree.outward:
        joint = tree.joints[name]
        parent = places[joint.parent]
        fixed = frame(joint.at, joint.orientation).within(parent.frame)
        child = frame(joint.child_at, joint.child_orientation).inverse()
        if joint.moves:
            places[joint.child] = Place(len(joints), child)
            joints.append((name, parent.body, fixed, joint))
        else:
            places[joint.child] = Place(parent.body, child.within(_locked(joint).within(fixed)))
    return joints, places


def _direction(joint: Joint) -> Array:
    axis = np.array(joint.axis, dtype=float)
    return axis / float(np.linalg.norm(axis))


def _locked(joint: Joint) -> Frame:
    if joint.locked is None:
        return HERE
    if joint.kind == SLIDER:
        return Frame(np.eye(3), joint.locked * _direction(joint))
    return Frame(about(_direction(joint), joint.locked), np.zeros(3))


def _together(links: Mapping[str, Link], places: Mapping[str, Place], number: int) -> tuple[float, Array, Array]:
    """Mass, centre of mass and inertia about it of all links of a body, in its frame."""
    here = [(link, places[name].frame) for name, link in links.items() if places[name].body == number]
    mass = sum(link.mass for link, _ in here)
    centres = [where.turned @ np.array(link.com) + where.at for link, where in here]
    com = sum((link.mass * at for (link, _), at in zip(here, centres, strict=True)), np.zeros(3)) / (mass or 1.0)
    inertia = np.zeros((3, 3))
    for (link, where), at in zip(here, centres, strict=True):
        # Steiner: I + m (|r|² 1 − r rᵀ), and |r|² 1 − r rᵀ = KᵀK with K v = r × v
        K = cross(at - com)
        inertia += where.turned @ link.tensor @ where.turned.T + link.mass * K.T @ K
    return mass, com, inertia
