"""Paths as mechanism files have them, and with some of their coordinates held."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ....model.skeleton.paths import Path, constant_moment_arms, exponents, polynomial
from ....model.skeleton.tree import TreeError
from ...files.errors import ScenarioError
from ...files.numbers import whole, within
from ...files.quote import shown
from ..muscles.keys import refuse_missing, refuse_unknown
from ..opensim.document import listed
from ..opensim.paths import Polynomial
from .parameters import COEFFICIENT, JOINTS_MOST, LENGTH, MOMENT_ARM, ORDER_MOST

_POLYNOMIAL = ["joints", "order", "coefficients"]
_MOMENT_ARMS = ["length", "moment_arms"]


def path_of(where: str, given: object) -> Path:
    """The path of a file's table, which has the place `where`. ScenarioError or TreeError says what is wrong."""
    if not isinstance(given, dict):
        raise ScenarioError(f"{where} must be a table, {{ joints, order, coefficients }}, not {shown(given)}")
    keys = _MOMENT_ARMS if any(key in given for key in _MOMENT_ARMS) else _POLYNOMIAL
    refuse_unknown(given, keys, f"{where}.")
    refuse_missing([f"{where}.{key}" for key in keys if key not in given])
    if keys is _MOMENT_ARMS:
        arms = given["moment_arms"]
        if not isinstance(arms, dict):
            raise ScenarioError(f"{where}.moment_arms must be a table, {{ joint = … }}, not {shown(arms)}")
        numbers = {joint: within(f"{where}.moment_arms.{joint}", arm, MOMENT_ARM) for joint, arm in arms.items()}
        return constant_moment_arms(within(f"{where}.length", given["length"], LENGTH), numbers)
    joints, coefficients = (given[key] for key in ("joints", "coefficients"))
    if not isinstance(joints, list) or not all(isinstance(joint, str) for joint in joints):
        raise ScenarioError(f"{where}.joints must be a list of names, not {shown(joints)}")
    if not isinstance(coefficients, list):
        raise ScenarioError(f"{where}.coefficients must be a list of numbers, not {shown(coefficients)}")
    order = whole(f"{where}.order", given["order"], 0)
    return _checked(
        where,
        joints,
        order,
        [within(f"{where}.coefficients[{number}]", value, COEFFICIENT) for number, value in enumerate(coefficients)],
    )


def path_over(muscle: str, given: Polynomial, joints: Mapping[str, str], held: Mapping[str, float]) -> Path:
    """A polynomial of OpenSim over joints, by its coordinates' names, some of which stay at a number.

    ScenarioError if a coordinate is neither, for a wrong number of coefficients, or if they stay too far out.
    """
    if unknown := [name for name in given.coordinates if name not in joints and name not in held]:
        known = listed(dict.fromkeys([*joints, *held])) or "none"
        raise ScenarioError(
            f"the path of {muscle} crosses {shown(unknown[0])}, which is no coordinate; there are {known}"
        )
    whole_path = _checked(f"the path of {muscle}", list(given.coordinates), given.order, list(given.coefficients))
    try:
        free = held_at(whole_path, held)
    except OverflowError as error:
        far = ", ".join(f"{name} = {held[name]:g}" for name in given.coordinates if name in held)
        raise ScenarioError(f"the path of {muscle} is no number where {far}") from error
    return Path(tuple(joints[name] for name in free.joints), free.terms)


def held_at(path: Path, values: Mapping[str, float]) -> Path:
    """The path over the joints that are left, where those in `values` stay at a number."""
    left = [place for place, joint in enumerate(path.joints) if joint not in values]
    if len(left) == len(path.joints):
        return path
    terms: dict[tuple[int, ...], float] = {}
    for powers, number in path.terms.items():
        factor = math.prod(values[j] ** e for j, e in zip(path.joints, powers, strict=True) if j in values)
        key = tuple(powers[place] for place in left)
        terms[key] = terms.get(key, 0.0) + factor * number
    joints = tuple(path.joints[place] for place in left)
    return polynomial(joints, *_dense(Path(joints, terms)))


def path_table(path: Path) -> dict[str, object]:
    """The path as a table of a file, from which `path_of` makes it again."""
    units = {tuple(int(other == joint) for other in path.joints): joint for joint in path.joints}
    constant = (0,) * len(path.joints)
    if path.joints and sorted(path.terms) == sorted([constant, *units]):
        arms = {joint: -path.terms[powers] for powers, joint in units.items()}
        return {"length": path.terms[constant], "moment_arms": arms}
    order, coefficients = _dense(path)
    return {"joints": list(path.joints), "order": order, "coefficients": coefficients}


def _dense(path: Path) -> tuple[int, list[float]]:
    """The order, and all coefficients up to it."""
    order = max(map(sum, path.terms), default=0)
    return order, [path.terms.get(e, 0.0) for e in exponents(order, len(path.joints))]


def _checked(where: str, joints: list[str], order: int, coefficients: list[float]) -> Path:
    if len(joints) > JOINTS_MOST or order > ORDER_MOST:
        raise ScenarioError(
            f"{where}: a polynomial of order {order} in {len(joints)} joints is too large; "
            f"at most {ORDER_MOST} in {JOINTS_MOST}"
        )
    if repeated := [joint for joint in joints if joints.count(joint) > 1]:
        raise ScenarioError(f"{where}: {shown(repeated[0])} is there twice")
    try:
        return polynomial(joints, order, coefficients)
    except TreeError as error:
        raise ScenarioError(f"{where}: {error}") from error
