"""Links and joints as they are described, in any consistent units, and what makes a tree of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..arrays import Array
from ..errors import Error

Vector = tuple[float, float, float]

GROUND = "ground"
PIN, SLIDER, WELD = KINDS = ("pin", "slider", "weld")
_ORIGIN: Vector = (0.0, 0.0, 0.0)


class TreeError(Error, ValueError):
    """Links and joints that make no tree; the sentence names them."""


@dataclass(frozen=True)
class Link:
    """A rigid body: mass kg, and in its frame the centre of mass com m and xx, yy, zz, xy, xz, yz of the inertia kg m².

    The inertia is about the centre of mass.
    """

    mass: float = 0.0
    com: Vector = _ORIGIN
    inertia: tuple[float, ...] = (0.0,) * 6

    @property
    def tensor(self) -> Array:
        """The inertia (3 × 3)."""
        xx, yy, zz, xy, xz, yz = self.inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@dataclass(frozen=True)
class Joint:
    """Two frames that coincide but for a rotation about an axis or a shift along it.

    kind: "pin" turns, "slider" shifts, "weld" does neither.
    One frame is fixed to the parent, `at` this place and turned by `orientation` about its own x, y, z one after the
    other; the other, by child_at and child_orientation, to the child. The coordinate is the angle in rad or the shift;
    its spring and damper make the force −stiffness (q − rest) − damping q̇. Where it is locked it is that number;
    where it is prescribed something else moves it, whatever pulls. range: what it may be. alias: another name for its
    coordinate, and opensim: for itself, as OpenSim's files have it.
    """

    parent: str
    child: str
    kind: str = PIN
    axis: Vector = (0.0, 0.0, 1.0)
    at: Vector = _ORIGIN
    orientation: Vector = _ORIGIN
    child_at: Vector = _ORIGIN
    child_orientation: Vector = _ORIGIN
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    range: tuple[float, float] | None = None
    locked: float | None = None
    prescribed: bool = False
    alias: str = ""
    opensim: str = ""

    @property
    def moves(self) -> bool:
        """Whether it has a coordinate."""
        return self.kind != WELD and self.locked is None


@dataclass(frozen=True)
class Tree:
    """Links by name, held by joints by name, below the ground, in a field of gravity (m/s²).

    outward: the joints in an order in which each comes after those that carry it.
    TreeError if a joint names no link, a link hangs in no joint or in two, or links hang in a circle.
    """

    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    gravity: Vector = _ORIGIN
    outward: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        for name, joint in self.joints.items():
            _check_joint(name, joint, self.links)
        for name, link in self.links.items():
            _check_link(name, link)
        object.__setattr__(self, "outward", tuple(_outward(self.links, self.joints)))

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The joints that move, in the order in which they were described."""
        return tuple(name for name, joint in self.joints.items() if joint.moves)

    @property
    def free(self) -> tuple[str, ...]:
        """Of these, those that the muscles move."""
        return tuple(name for name in self.coordinates if not self.joints[name].prescribed)

    def scaled(self, length: float, mass: float, rate: float) -> Tree:
        """The same tree in other units: these of length and mass, and 1/rate of time; angles stay in rad."""
        links = {
            name: Link(
                link.mass / mass,
                _over(link.com, length),
                tuple(number / (mass * length**2) for number in link.inertia),
            )
            for name, link in self.links.items()
        }
        joints = {name: _scaled_joint(joint, length, mass, rate) for name, joint in self.joints.items()}
        return Tree(links, joints, _over(self.gravity, length * rate**2))


def _over(vector: Vector, unit: float) -> Vector:
    x, y, z = vector
    return x / unit, y / unit, z / unit


def _scaled_joint(joint: Joint, length: float, mass: float, rate: float) -> Joint:
    # of the coordinate, and of the torque or force that belongs to it
    q = length if joint.kind == SLIDER else 1.0
    torque = mass * length**2 * rate**2 / q
    return replace(
        joint,
        at=_over(joint.at, length),
        child_at=_over(joint.child_at, length),
        stiffness=joint.stiffness * q / torque,
        rest=joint.rest / q,
        damping=joint.damping * q * rate / torque,
        range=joint.range and (joint.range[0] / q, joint.range[1] / q),
        locked=None if joint.locked is None else joint.locked / q,
    )


def _check_joint(name: str, joint: Joint, links: Mapping[str, Link]) -> None:
    if joint.kind not in KINDS:
        raise TreeError(f"joint {name}: its type is one of {', '.join(KINDS)}, not {joint.kind!r}")
    for what, link in (("parent", joint.parent), ("child", joint.child)):
        if link not in links and not (what == "parent" and link == GROUND):
            known = ", ".join([*([GROUND] if what == "parent" else []), *links]) or "none"
            raise TreeError(f"joint {name}: its {what} {link!r} is no link; there are {known}")
    if joint.kind != WELD and not np.linalg.norm(joint.axis) > 0:
        raise TreeError(f"joint {name}: its axis is 0 0 0, which has no direction")
    if joint.range is not None and not joint.range[0] < joint.range[1]:
        raise TreeError(f"joint {name}: its range must rise, not go from {joint.range[0]:g} to {joint.range[1]:g}")


# of a symmetric matrix
_MOMENTS = 6
# of the largest: what is less is rounding of a number with six digits
_ROUNDING = 1e-5


def _check_link(name: str, link: Link) -> None:
    if len(link.inertia) != _MOMENTS:
        raise TreeError(
            f"link {name}: its inertia has {_MOMENTS} numbers, xx, yy, zz, xy, xz, yz, not {len(link.inertia)}"
        )
    principal = np.linalg.eigvalsh(link.tensor)
    if principal[0] < -_ROUNDING * abs(principal).max():
        raise TreeError(
            f"link {name}: its inertia is not positive definite, a principal moment is {principal[0]:.3g}; "
            "it is xx, yy, zz, xy, xz, yz about the centre of mass"
        )


def _outward(links: Mapping[str, Link], joints: Mapping[str, Joint]) -> Iterator[str]:
    """The joints, each after the one that holds its parent."""
    holds: dict[str, str] = {}
    for name, joint in joints.items():
        if (other := holds.setdefault(joint.child, name)) != name:
            raise TreeError(f"link {joint.child} hangs in two joints, {other} and {name}; a tree has one for each")
    if loose := [name for name in links if name not in holds]:
        raise TreeError(f"link {loose[0]} hangs in no joint; each link is the child of one")
    known, waiting = {GROUND}, dict(joints)
    while ready := [name for name, joint in waiting.items() if joint.parent in known]:
        for name in ready:
            known.add(waiting.pop(name).child)
            yield name
    if waiting:
        raise TreeError(f"links hang in a circle: {' → '.join(_circle(next(iter(waiting.values())).child, joints))}")


def _circle(link: str, joints: Mapping[str, Joint]) -> list[str]:
    parent = {joint.child: joint.parent for joint in joints.values()}
    path: list[str] = []
    while link not in path:
        path.append(link)
        link = parent[link]
    return [*path[path.index(link) :], link][::-1]
