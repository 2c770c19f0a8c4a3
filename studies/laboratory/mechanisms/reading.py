"""A mechanism from a TOML file, checked key by key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, cast

from ....model.arrays import is_number
from ....model.block import Parameter
from ....model.fibre import PENNATION
from ....model.skeleton.points import Point
from ....model.skeleton.tree import KINDS, WELD, Joint, Link, Tree, TreeError, Vector
from ...files.errors import ScenarioError, in_file
from ...files.numbers import switch, within
from ...files.quote import shown, text
from ...files.toml import read_toml
from ..muscles.keys import refuse_missing, refuse_unknown, section
from ..muscles.tables import COMMON, MuscleTables
from ..opensim.paths import read_paths
from .mechanism import Mechanism
from .parameters import FRAMES, GRAVITY, LINK, MOVING, POINT, Numbers
from .paths import held_at, path_of, path_over

# bytes; hundreds of muscles over six joints each
LARGEST_FILE = 5_000_000
# what a file calls a field of a Joint, where it is another word
KEYS: Mapping[str, str] = {"kind": "type", "alias": "coordinate"}
_TOP = ["description", "gravity", "paths", "links", "joints", "points", COMMON, "muscles"]


def read_mechanism(path: str | Path) -> Mechanism:
    """The mechanism of the TOML file `path`, docs/mechanisms.md.

    ScenarioError names the file and the key that is wrong, missing or unknown.

    >>> arm = hillobs.read_mechanism("studies/laboratory/recordings/arm.toml")
    >>> list(arm.paths)
    ['TRIlong', 'TRIlat', 'TRImed', 'BIClong', 'BICshort', 'BRA']
    """
    content = read_toml(Path(path), LARGEST_FILE)
    with in_file(path):
        return mechanism_of(content, Path(path).parent)


def mechanism_of(content: Mapping[str, object], folder: Path | None = Path()) -> Mechanism:
    """The mechanism of a TOML document, docs/mechanisms.md. ScenarioError as above.

    folder: where files of paths and of curves are looked for; None if there must be none.
    """
    if "mass" in content:
        raise ScenarioError("it has a mass and no joints, so it is a pair: --muscles, or read_muscles")
    refuse_unknown(content, _TOP, "")
    try:
        return _mechanism(content, folder)
    except TreeError as error:
        raise ScenarioError(str(error)) from error


def _mechanism(content: Mapping[str, object], folder: Path | None) -> Mechanism:
    description = text("description", content.get("description", ""))
    gravity = cast(Vector, _number("gravity", content.get("gravity", [0.0] * GRAVITY.count), GRAVITY))
    links = {name: _link(f"links.{name}", table) for name, table in _tables(content, "links").items()}
    joints = {name: _joint(f"joints.{name}", table) for name, table in _tables(content, "joints").items()}
    tree = Tree(links, joints, gravity)
    if not (own := _tables(content, "muscles")):
        raise ScenarioError("a mechanism needs a muscle or more, each a table [muscles.…]")
    each = {f"muscles.{name}": table for name, table in own.items()}
    tables = MuscleTables.read(section(content, COMMON), each, folder, {"pennation": PENNATION}, ["path"])
    refuse_missing(tables.missing)
    muscles = dict(zip(own, tables.muscles(), strict=True))
    points = {name: _point(f"points.{name}", table) for name, table in _tables(content, "points").items()}
    return Mechanism(tree, muscles, _paths(content, folder, tree, own), description, points)


def _paths(
    content: Mapping[str, object], folder: Path | None, tree: Tree, muscles: Mapping[str, Mapping[str, object]]
) -> dict[str, Any]:
    """The path of each muscle that has one, its own before that of the file; locked joints stay where they are."""
    locked = {name: joint.locked for name, joint in tree.joints.items() if joint.locked is not None}
    found = {
        name: held_at(path_of(f"muscles.{name}.path", table["path"]), locked)
        for name, table in muscles.items()
        if "path" in table
    }
    if "paths" not in content:
        return found
    file = text("paths", content["paths"])
    if folder is None:
        raise ScenarioError("paths must not be a file here; give each muscle its path")
    of_file = read_paths(folder / file)
    called = {name: name for name in tree.joints}
    called |= {joint.alias: name for name, joint in tree.joints.items() if joint.alias}
    held = {name: locked[joint] for name, joint in called.items() if joint in locked}
    for name in muscles:
        if name in of_file and name not in found:
            found[name] = path_over(name, of_file[name], called, held)
    return found


def _link(where: str, table: Mapping[str, object]) -> Link:
    refuse_unknown(table, list(LINK), f"{where}.")
    refuse_missing([f"{where}.mass"] if "mass" not in table else [])
    return Link(**_values(where, table, LINK))


def _point(where: str, table: Mapping[str, object]) -> Point:
    refuse_unknown(table, ["link", *POINT], f"{where}.")
    refuse_missing([f"{where}.{key}" for key in ("link", *POINT) if key not in table])
    return Point(text(f"{where}.link", table["link"]), **_values(where, table, POINT))


def _joint(where: str, table: Mapping[str, object]) -> Joint:
    refuse_missing([f"{where}.{key}" for key in ("type", "parent", "child") if key not in table])
    kind = table["type"]
    if not isinstance(kind, str) or kind not in KINDS:
        raise ScenarioError(f"{where}.type must be one of {', '.join(KINDS)}, not {shown(kind)}")
    moving = MOVING.get(kind, {})
    words = ["type", "parent", "child", *(["coordinate", "opensim"] if kind != WELD else [])]
    refuse_unknown(table, [*words, *FRAMES, *moving, *(["prescribed"] if moving else [])], f"{where}.")
    refuse_missing([f"{where}.axis"] if moving and "axis" not in table else [])
    known = {**FRAMES, **moving}
    values: dict[str, Any] = _values(where, table, known)
    values |= {
        field.name: text(f"{where}.{key}", table[key])
        for field in fields(Joint)
        if (key := KEYS.get(field.name, field.name)) in words and key in table
    }
    values["prescribed"] = switch(f"{where}.prescribed", table.get("prescribed", False))
    if values["prescribed"] and "locked" in values:
        raise ScenarioError(f"{where}: is locked and prescribed; it can be one of them")
    return Joint(**values)


def _values(where: str, table: Mapping[str, object], known: Mapping[str, Parameter | Numbers]) -> dict[str, Any]:
    return {key: _number(f"{where}.{key}", table[key], known[key]) for key in known if key in table}


def _number(where: str, value: object, known: Parameter | Numbers) -> float | tuple[float, ...]:
    if isinstance(known, Parameter):
        return _within(where, value, known)
    if not isinstance(value, list) or len(value) != known.count:
        raise ScenarioError(f"{where} must be a list of {known.count} numbers, not {shown(value)}")
    return tuple(_within(f"{where}[{number}]", inner, known.each) for number, inner in enumerate(value))


def _within(where: str, value: object, known: Parameter) -> float:
    try:
        return within(where, value, known)
    except ScenarioError as error:
        # what is beyond a few turns was meant otherwise
        if known.unit == "rad" and is_number(value):
            raise ScenarioError(f"{error} (rad; is it in degrees?)") from error
        raise


def _tables(content: Mapping[str, object], name: str) -> dict[str, dict[str, object]]:
    """The tables in one of the document's tables."""
    outer = section(content, name)
    return {key: section(outer, key, f"{name}.") for key in outer}
