"""A model as a tree, muscles and polynomials, with all that was not taken in sentences."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ....model.skeleton.points import Point
from ....model.skeleton.tree import Joint, Tree, TreeError
from ...files.errors import ScenarioError, in_file
from ...files.quote import shown
from ..muscles import Muscle
from .bodies import bodies, link
from .constraints import cut
from .document import Component, Document, listed, read_document
from .forces import acting, left_out, springs, sprung
from .frames import vector
from .joints import ReadJoint, joints
from .markers import markers
from .muscles import chosen_muscles, muscle, muscles
from .names import Coordinates
from .paths import TAG, Polynomial, polynomial_of, read_paths

_GRAVITY = (0.0, -9.80665, 0.0)
_UNITS = {"length_units": ("meters", "meter", "m"), "force_units": ("newtons", "newton", "n")}


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
    points: Mapping[str, Point]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class FitRequest:
    """What must be known to fit polynomials for the muscles that have none.

    ranges: coordinate → what it may be, where it is free or in a joint with one that is; joints: coordinate → its
    joint; welded: joints whose coordinates are all held. Names are those of the model.
    """

    model: Path
    muscles: tuple[str, ...]
    ranges: Mapping[str, tuple[float, float] | None]
    joints: Mapping[str, str]
    held: Mapping[str, float]
    welded: tuple[str, ...]


# polynomials by the muscle's name
Fit = Callable[[FitRequest], Mapping[str, Polynomial]]


def read_model(
    path: Path,
    paths: Path | None = None,
    locks: Mapping[str, float] | None = None,
    only: Sequence[str] = (),
    ranges: Mapping[str, tuple[float, float]] | None = None,
    fit: Fit | None = None,
) -> OpenSimModel:
    """The model of an .osim file, with the muscles that are named, or all.

    paths: a file of polynomials, which count more than those of the model; locks and ranges by a joint or a coordinate;
    fit: makes those that are missing.
    ScenarioError names the file and what is not taken, with a way where there is one.
    """
    polynomials = read_paths(paths) if paths else {}
    with in_file(path):
        try:
            return _model(path, polynomials, locks or {}, only, ranges or {}, fit)
        except TreeError as error:
            raise ScenarioError(str(error)) from error


def _model(
    path: Path,
    polynomials: Mapping[str, Polynomial],
    locks: Mapping[str, float],
    only: Sequence[str],
    ranges: Mapping[str, tuple[float, float]],
    fit: Fit | None,
) -> OpenSimModel:
    document = read_document(path)
    _check_units(document)
    of_bodies = bodies(document)
    of_joints = joints(document, of_bodies)
    coordinates = Coordinates(of_joints)
    held = {own.name: own.value for joint in of_joints for own in joint.coordinates if own.locked}
    held |= coordinates.by_coordinate(locks)
    limits = coordinates.by_coordinate(ranges)
    forces = acting(document)
    of_springs = springs(forces, coordinates.names)
    tree_joints = {
        coordinates.joint_names[joint.name]: _limited(
            sprung(_renamed(joint, joint.held(held), coordinates), of_springs), limits
        )
        for joint in of_joints
    }
    gravity = vector(document.component(document.model).numbers("gravity", 3, _GRAVITY))
    tree = Tree({name: link(body) for name, body in of_bodies.items()}, tree_joints, gravity)
    chosen = chosen_muscles(forces, only)
    read = {name: muscle(component) for name, component in chosen.items()}
    couplings = list(cut(document, held))
    of_muscles = _polynomials(chosen, polynomials)
    if missing := [name for name in chosen if name not in of_muscles]:
        if fit is None:
            raise ScenarioError(
                f"{listed(missing)}: geometry without polynomials is not read; fit them with --fit, or with "
                "OpenSim's PolynomialPathFitter, and name its FunctionBasedPathSet.xml with --paths"
            )
        there = tuple(chosen[name].name for name in missing)
        fitted = fit(
            _request(path, there, of_joints, held, {joint.alias: joint.range for joint in tree_joints.values()})
        )
        of_muscles |= {name: fitted[chosen[name].name] for name in missing}
    notes = [
        *couplings,
        *(sentence for _, sentences in read.values() for sentence in sentences),
        *(
            f"{name}: moment arms follow from its length; the functions beside it are not read"
            for name, own in of_muscles.items()
            if own.separate
        ),
        *left_out(forces, muscles(forces)),
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
        markers(document, of_bodies, {*tree_joints, *read}),
        tuple(notes),
    )


def _check_units(document: Document) -> None:
    for tag, units in _UNITS.items():
        given = document.component(document.model).words(tag) or units[0]
        if given.lower() not in units:
            raise ScenarioError(f"{tag} must be {units[0]}, not {shown(given)}")


def _renamed(read: ReadJoint, joint: Joint, coordinates: Coordinates) -> Joint:
    """It remembers the model's name, where it has another."""
    moves = joint.alias and coordinates.joint_names[read.name] != read.name
    return replace(joint, opensim=read.name) if moves else joint


def _limited(joint: Joint, limits: Mapping[str, tuple[float, float]]) -> Joint:
    return replace(joint, range=limits[joint.alias]) if joint.alias in limits else joint


def _polynomials(chosen: Mapping[str, Component], given: Mapping[str, Polynomial]) -> dict[str, Polynomial]:
    """The path of each muscle that has one."""
    found: dict[str, Polynomial] = {}
    for name, component in chosen.items():
        if component.name in given:
            found[name] = given[component.name]
        elif (element := component.child(TAG)) is not None:
            found[name] = polynomial_of(element)
    return found


def _request(
    path: Path,
    muscles: tuple[str, ...],
    of_joints: Sequence[ReadJoint],
    held: Mapping[str, float],
    limits: Mapping[str, tuple[float, float] | None],
) -> FitRequest:
    """What a fit must know; a coordinate that stays beside a free one has no width."""
    still = {joint.name for joint in of_joints if all(own.name in held for own in joint.coordinates)}
    moving = [joint for joint in of_joints if joint.name not in still]
    return FitRequest(
        path,
        muscles,
        {
            own.name: (held[own.name], held[own.name]) if own.name in held else limits[own.name]
            for joint in moving
            for own in joint.coordinates
        },
        {own.name: joint.name for joint in moving for own in joint.coordinates},
        held,
        tuple(joint.name for joint in of_joints if joint.name in still and joint.coordinates),
    )
