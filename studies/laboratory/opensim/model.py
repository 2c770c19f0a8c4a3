"""A model as a tree, muscles and polynomials, with all that was not taken in sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ....model.skeleton.tree import Joint, Tree, TreeError
from ...files.errors import ScenarioError, in_file
from ...files.quote import shown
from ..muscles import Muscle
from .bodies import bodies, link
from .constraints import cut
from .document import Component, Document, read_document
from .forces import acting, left_out, springs, sprung
from .frames import vector
from .joints import ReadJoint, joints
from .muscles import CLASSES, muscle
from .paths import TAG, Polynomial, polynomial_of, read_paths

_MUSCLE = "Muscle"
_SIDES = ("r", "l", "R", "L", "right", "left", "Right", "Left")
_GRAVITY = (0.0, -9.80665, 0.0)


@dataclass(frozen=True)
class OpenSimModel:
    """What a model gives: kg, m, rad, N.

    joints: coordinate → the joint that moves by it; held: coordinate → the number at which it stays, and no joint of
    the tree has it or that one is locked; classes: muscle → its class there.
    """

    name: str
    credits: str
    tree: Tree
    joints: Mapping[str, str]
    held: Mapping[str, float]
    muscles: Mapping[str, Muscle]
    classes: Mapping[str, str]
    polynomials: Mapping[str, Polynomial]
    notes: tuple[str, ...]


def read_model(
    path: Path,
    paths: Path | None = None,
    locks: Mapping[str, float] | None = None,
    only: Sequence[str] = (),
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> OpenSimModel:
    """The model of an .osim file, with the muscles that are named, or all.

    paths: a file of polynomials, which count more than those of the model; locks and ranges by a joint or a coordinate.
    ScenarioError names the file and what is not taken, with a way where there is one.
    """
    polynomials = read_paths(paths) if paths else {}
    with in_file(path):
        try:
            return _model(read_document(path), polynomials, locks or {}, only, ranges or {})
        except TreeError as error:
            raise ScenarioError(str(error)) from error


def _model(
    document: Document,
    polynomials: Mapping[str, Polynomial],
    locks: Mapping[str, float],
    only: Sequence[str],
    ranges: Mapping[str, tuple[float, float]],
) -> OpenSimModel:
    of_bodies = bodies(document)
    of_joints = joints(document, of_bodies)
    coordinates = _Coordinates(of_joints)
    held = {own.name: own.value for joint in of_joints for own in joint.coordinates if own.locked}
    held |= {coordinates.find(name): value for name, value in locks.items()}
    limits = {coordinates.find(name): limit for name, limit in ranges.items()}
    forces = acting(document)
    of_springs = springs(forces, coordinates.names)
    tree_joints = {
        coordinates.joint_names[joint.name]: _limited(sprung(joint.held(held), of_springs), limits)
        for joint in of_joints
    }
    gravity = vector(document.component(document.model).numbers("gravity", 3, _GRAVITY))
    tree = Tree({name: link(body) for name, body in of_bodies.items()}, tree_joints, gravity)
    chosen = _chosen(forces, only)
    read = {name: muscle(component) for name, component in chosen.items()}
    of_muscles = _polynomials(chosen, polynomials, coordinates.names)
    notes = [
        *cut(document, held),
        *(sentence for _, sentences in read.values() for sentence in sentences),
        *(
            f"{name}: moment arms follow from its length; the functions beside it are not read"
            for name, own in of_muscles.items()
            if own.separate
        ),
        *left_out(forces, _muscles(forces)),
    ]
    return OpenSimModel(
        document.model.name,
        document.component(document.model).words("credits") or "",
        tree,
        {joint.alias: name for name, joint in tree_joints.items() if joint.alias},
        held,
        {name: own for name, (own, _) in read.items()},
        {name: component.element.tag for name, component in chosen.items()},
        of_muscles,
        tuple(notes),
    )


class _Coordinates:
    """The coordinates of joints, and what each may be called."""

    def __init__(self, of_joints: list[ReadJoint]) -> None:
        self.names = [own.name for joint in of_joints for own in joint.coordinates]
        moving = [joint.name for joint in of_joints if joint.coordinates]
        self.joint_names = {joint.name: joint.name for joint in of_joints}
        self.joint_names |= dict(zip(moving, without_side(moving), strict=True))
        self._called: dict[str, list[str]] = {}
        for joint in of_joints:
            for called in {joint.name, self.joint_names[joint.name]}:
                self._called[called] = [own.name for own in joint.coordinates]
        self._called |= {name: [name] for name in self.names}

    def find(self, called: str) -> str:
        """The coordinate with this name, or that of the joint. ScenarioError if there is none, or more than one."""
        found = self._called.get(called, [])
        if len(found) == 1:
            return found[0]
        among = found or self.names
        raise ScenarioError(
            f"{shown(called)} {'has more than one coordinate' if found else 'is no joint and no coordinate'}; "
            f"there are {', '.join(among) or 'none'}"
        )


def without_side(names: list[str]) -> list[str]:
    """The names without the side, r_ or _l, where all have the same and none is lost."""
    for cut_off in (str.removeprefix, str.removesuffix):
        for side in _SIDES:
            mark = f"{side}_" if cut_off is str.removeprefix else f"_{side}"
            plain = [cut_off(name, mark) for name in names]
            if all(short and short != name for short, name in zip(plain, names, strict=True)):
                return plain
    return names


def _limited(joint: Joint, limits: Mapping[str, tuple[float, float]]) -> Joint:
    return replace(joint, range=limits[joint.alias]) if joint.alias in limits else joint


def _muscles(forces: list[Component]) -> dict[str, Component]:
    found: dict[str, Component] = {}
    for force in forces:
        if force.element.tag.endswith(_MUSCLE):
            if force.name in found:
                raise ScenarioError(f"{force.where}: there is another muscle {shown(force.name)}")
            found[force.name] = force
    return found


def _chosen(forces: list[Component], only: Sequence[str]) -> dict[str, Component]:
    """The muscles that are wanted. ScenarioError if one is not there, or of a class that is not read."""
    found = _muscles(forces)
    if not found:
        raise ScenarioError("has no muscles")
    if missing := [name for name in only if name not in found]:
        raise ScenarioError(f"has no muscle {shown(missing[0])}; there are {', '.join(found)}")
    chosen = {name: component for name, component in found.items() if not only or name in only}
    for component in chosen.values():
        if component.element.tag not in CLASSES:
            raise ScenarioError(
                f"{component.where}: muscles of this class are not read, but {', '.join(CLASSES)}; "
                "leave it out by naming others with --muscles"
            )
    return chosen


def _polynomials(
    chosen: Mapping[str, Component], given: Mapping[str, Polynomial], coordinates: list[str]
) -> dict[str, Polynomial]:
    """The path of each muscle. ScenarioError if one has none, or crosses what is no coordinate."""
    own = {name: element for name, component in chosen.items() if (element := component.child(TAG)) is not None}
    found = {
        name: given[name] if name in given else polynomial_of(own[name]) for name in chosen if name in {**own, **given}
    }
    if missing := [name for name in chosen if name not in found]:
        raise ScenarioError(
            f"{', '.join(missing)}: geometry without polynomials is not read; fit them with --fit, or with OpenSim's "
            "PolynomialPathFitter, and name its FunctionBasedPathSet.xml with --paths"
        )
    for name, path in found.items():
        if unknown := [called for called in path.coordinates if called not in coordinates]:
            raise ScenarioError(
                f"the path of {name} crosses {shown(unknown[0])}, which is no coordinate; "
                f"there are {', '.join(coordinates)}"
            )
    return found
