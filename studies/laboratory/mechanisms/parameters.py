"""The numbers of links and joints in a mechanism file: units, and ranges that find other units than these."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ....model.block import Parameter
from ....model.skeleton.tree import PIN, SLIDER

FILE = "mechanism file"


@dataclass(frozen=True)
class Numbers:
    """So many numbers of one kind."""

    count: int
    each: Parameter


# m: bodies and places, in a laboratory; millimetres where metres belong are beyond
_PLACE = Numbers(3, Parameter(0.0, "place", FILE, "m", least=-20, most=20))
# rad: a turn in either direction
_TURN = Numbers(3, Parameter(0.0, "angles about x, y, z", FILE, "rad", least=-2 * math.pi, most=2 * math.pi))

GRAVITY = Numbers(3, Parameter(0.0, "acceleration of gravity", FILE, "m/s2", least=-1000, most=1000))
LINK: Mapping[str, Parameter | Numbers] = {
    "mass": Parameter(0.0, "mass", FILE, "kg", least=0, most=1e6),
    "com": _PLACE,
    "inertia": Numbers(6, Parameter(0.0, "xx yy zz xy xz yz about the centre of mass", FILE, "kg m2", most=1e7)),
}
# of a point, in the frame of its link
POINT: Mapping[str, Parameter | Numbers] = {"at": _PLACE}
FRAMES: Mapping[str, Parameter | Numbers] = {
    "at": _PLACE,
    "orientation": _TURN,
    "child_at": _PLACE,
    "child_orientation": _TURN,
}
# rad: OpenSim's coordinates without a range have 10; degrees are beyond
_ANGLE = Parameter(0.0, "angle", FILE, "rad", least=-12, most=12)
_SHIFT = Parameter(0.0, "position", FILE, "m", least=-20, most=20)


def _moving(coordinate: Parameter, force: str) -> dict[str, Parameter | Numbers]:
    unit = coordinate.unit
    return {
        "axis": Numbers(3, Parameter(0.0, "direction, of any length", FILE)),
        "range": Numbers(2, coordinate),
        "damping": Parameter(0.0, "what a damper holds back", FILE, f"{force} s/{unit}", least=0, most=1e9),
        "stiffness": Parameter(0.0, "that of a spring", FILE, f"{force}/{unit}", least=0, most=1e9),
        "rest": coordinate,
        "locked": coordinate,
    }


# what a joint has beside its frames, by its type
MOVING: Mapping[str, Mapping[str, Parameter | Numbers]] = {
    PIN: _moving(_ANGLE, "N m"),
    SLIDER: _moving(_SHIFT, "N"),
}

# OpenSim's functions have at most six arguments, and its fitter at most the ninth order
ORDER_MOST, JOINTS_MOST = 12, 6
COEFFICIENT = Parameter(0.0, "coefficient of a polynomial, m per power of rad or m", FILE)
LENGTH = Parameter(0.0, "length at 0 of all coordinates", FILE, "m", least=-20, most=20)
MOMENT_ARM = Parameter(0.0, "moment arm, in m, or what a slider takes", FILE, "m", least=-10, most=10)
