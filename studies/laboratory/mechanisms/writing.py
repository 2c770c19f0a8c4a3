"""A mechanism as a TOML file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

from ....model.skeleton.tree import WELD, Joint
from ...files.toml import toml_document
from ..muscles.tables import COMMON, muscle_table
from .mechanism import Mechanism
from .paths import path_table
from .reading import KEYS

# what a joint that moves always says
_ALWAYS = ("parent", "child", "kind", "axis")


def mechanism_file(mechanism: Mechanism) -> dict[str, object]:
    """The mechanism as a document from which `mechanism_of` makes it again, number by number."""
    tree = mechanism.tree
    tables = {name: muscle_table(muscle) for name, muscle in mechanism.muscles.items()}
    common = _common(list(tables.values()))
    muscles = {
        name: {
            **{key: value for key, value in table.items() if key not in common},
            "path": path_table(mechanism.paths[name]),
        }
        for name, table in tables.items()
    }
    points = {name: {"link": point.link, "at": list(point.at)} for name, point in mechanism.points.items()}
    return {
        "description": mechanism.description,
        "gravity": list(tree.gravity),
        "links": {
            name: {"mass": link.mass, "com": list(link.com), "inertia": list(link.inertia)}
            for name, link in tree.links.items()
        },
        "joints": {name: _joint_table(joint) for name, joint in tree.joints.items()},
        **({"points": points} if points else {}),
        **({COMMON: common} if common else {}),
        "muscles": muscles,
    }


def mechanism_text(mechanism: Mechanism) -> str:
    """The same as the text of a TOML file."""
    return toml_document(mechanism_file(mechanism))


def _joint_table(joint: Joint) -> dict[str, object]:
    """What differs from what a joint has anyway."""
    plain = Joint("", "")
    table: dict[str, object] = {"type": joint.kind}
    for field in fields(Joint):
        value = getattr(joint, field.name)
        said = field.name in _ALWAYS or value != getattr(plain, field.name)
        if field.name != "kind" and said and not (field.name == "axis" and joint.kind == WELD):
            table[KEYS.get(field.name, field.name)] = list(value) if isinstance(value, tuple) else value
    return table


def _common(tables: list[dict[str, object]]) -> dict[str, object]:
    """What all muscles have, of two or more."""
    first: Mapping[str, object] = tables[0] if len(tables) > 1 else {}
    return {key: value for key, value in first.items() if all(key in table and table[key] == value for table in tables)}
