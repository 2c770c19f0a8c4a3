"""Names of a model: what joints and muscles are called here, and what a user may call a coordinate."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TypeVar

from ...files.errors import ScenarioError
from ...files.quote import shown
from .document import listed
from .joints import ReadJoint

# what the name of a joint or a muscle here may not have
_NO_LETTER = re.compile("[^A-Za-z0-9]+")
_Value = TypeVar("_Value")
_SIDES = ("r", "l", "R", "L", "right", "left", "Right", "Left")


class Coordinates:
    """The coordinates of joints, and what each may be called."""

    def __init__(self, of_joints: list[ReadJoint]) -> None:
        """Of a model's joints. ScenarioError if two would have one name here."""
        self.names = [own.name for joint in of_joints for own in joint.coordinates]
        moving = [joint.name for joint in of_joints if joint.coordinates]
        welds = {joint.name for joint in of_joints} - set(moving)
        short = without_side(moving)
        names = dict(zip(moving, moving if welds & set(short) else short, strict=True))
        self.joint_names = {joint.name: plain(names.get(joint.name, joint.name)) for joint in of_joints}
        refuse_equal(self.joint_names)
        self._called: dict[str, list[str]] = {}
        for joint in of_joints:
            for name in {joint.name, self.joint_names[joint.name]}:
                self._called[name] = [own.name for own in joint.coordinates]
        self._called |= {name: [name] for name in self.names}

    def find(self, called: str) -> str:
        """The coordinate with this name, or that of the joint. ScenarioError if there is none, or more than one."""
        found = self._called.get(called, [])
        if len(found) == 1:
            return found[0]
        among = found or self.names
        raise ScenarioError(
            f"{shown(called)} {'has more than one coordinate' if found else 'is no joint and no coordinate'}; "
            f"there are {listed(among) or 'none'}"
        )

    def by_coordinate(self, given: Mapping[str, _Value]) -> dict[str, _Value]:
        """What is given by any names, by coordinate. ScenarioError as above, and if two names are of one coordinate."""
        names: dict[str, str] = {}
        for name in given:
            if (before := names.setdefault(self.find(name), name)) != name:
                raise ScenarioError(
                    f"{shown(before)} and {shown(name)} are one coordinate, {self.find(name)}; it can be given once"
                )
        return {coordinate: given[name] for coordinate, name in names.items()}


def plain(name: str) -> str:
    """A name with _ for what may not be in one."""
    return _NO_LETTER.sub("_", name).strip("_")


def refuse_equal(called: Mapping[str, str]) -> None:
    """ScenarioError if two names of the model would be one here."""
    names = list(called.values())
    if equal := [there for there, here in called.items() if names.count(here) > 1]:
        raise ScenarioError(f"{' and '.join(map(shown, equal[:2]))} would both be called {called[equal[0]]}")


def without_side(names: list[str]) -> list[str]:
    """The names without the side, r_ or _l, where all have the same and none is lost."""
    for cut_off in (str.removeprefix, str.removesuffix):
        for side in _SIDES:
            mark = f"{side}_" if cut_off is str.removeprefix else f"_{side}"
            left = [cut_off(name, mark) for name in names]
            if all(short and short != name for short, name in zip(left, names, strict=True)):
                return left
    return names
