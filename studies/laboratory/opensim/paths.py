"""Lengths of muscles as polynomials: FunctionBasedPath, in a model or in a file of paths."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ...files.errors import ScenarioError, in_file
from ...files.quote import shown
from .document import Component, listed, read_root
from .xml import Element

TAG = "FunctionBasedPath"
_POLYNOMIAL = "MultivariatePolynomialFunction"
# separate fits, which need not be derivatives of the length
_SEPARATE = ("moment_arm_functions", "lengthening_speed_function")


@dataclass(frozen=True)
class Polynomial:
    """A muscle's length in m over coordinates, by their names; coefficients as OpenSim orders them.

    separate: whether moment arms or speeds of their own stand beside it.
    """

    coordinates: tuple[str, ...]
    order: int
    coefficients: tuple[float, ...]
    separate: bool = False


def read_paths(path: Path) -> dict[str, Polynomial]:
    """The polynomials of a file of paths or of a model, by the muscle's name. ScenarioError says what is wrong."""
    with in_file(path):
        found = _of_muscles(read_root(path))
        if not found:
            raise ScenarioError(f"has no {TAG}")
        return found


def polynomial_of(element: Element) -> Polynomial:
    """Of a FunctionBasedPath. ScenarioError names another function, or what is missing."""
    path = Component(element)
    coordinates = tuple(whole.rpartition("/")[2] for whole in (path.words("coordinate_paths") or "").split())
    if not coordinates:
        raise ScenarioError(f"{path.where} has no coordinate_paths")
    if repeated := [name for name in coordinates if coordinates.count(name) > 1]:
        raise ScenarioError(f"{path.where}: has the coordinate {shown(repeated[0])} twice")
    holder = element.child("length_function")
    functions = holder.children if holder else []
    if len(functions) != 1 or functions[0].tag != _POLYNOMIAL:
        given = listed(function.tag for function in functions) or "nothing"
        raise ScenarioError(f"{path.where}: its length_function must be a {_POLYNOMIAL}, not {given}")
    function = Component(functions[0])
    dimension, order = (_whole(path, function, tag) for tag in ("dimension", "order"))
    if dimension != len(coordinates):
        raise ScenarioError(
            f"{path.where}: a polynomial of {dimension} arguments does not fit the coordinates {listed(coordinates)}"
        )
    separate = any((held := element.child(tag)) is not None and held.children for tag in _SEPARATE)
    return Polynomial(coordinates, order, tuple(function.numbers("coefficients")), separate)


def _whole(path: Component, function: Component, tag: str) -> int:
    number = function.number(tag)
    if not number.is_integer() or number < 0:
        raise ScenarioError(f"{path.where}: its {tag} must be a whole number, not {number:g}")
    return int(number)


def _of_muscles(root: Element) -> dict[str, Polynomial]:
    found: dict[str, Polynomial] = {}
    for objects in (element for element in root.walk() if element.tag == "objects"):
        for member in objects.children:
            for path in [member] if member.tag == TAG else [held for held in member.children if held.tag == TAG]:
                name = member.name.rpartition("/")[2]
                if name in found:
                    raise ScenarioError(f"{Component(member).where}: there is another path of {shown(name)}")
                found[name] = polynomial_of(path)
    return found
