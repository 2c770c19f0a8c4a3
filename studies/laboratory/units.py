"""The units a recording may use, and how each becomes SI."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...model.arrays import Array
from ..files.errors import RecordingError
from ..files.quote import shown


@dataclass(frozen=True)
class Unit:
    """value in SI = value · times / over; a quotient of whole numbers rounds once."""

    symbol: str
    quantity: str
    times: float = 1
    over: float = 1

    def to_SI(self, values: Array) -> Array:
        """Values of this unit in SI."""
        return values if self.times == self.over else values * self.times / self.over

    def from_SI(self, values: Array) -> Array:
        """Values of SI in this unit."""
        return values if self.times == self.over else values * self.over / self.times


_UNITS = (
    Unit("s", "time"),
    Unit("ms", "time", over=1_000),
    Unit("us", "time", over=1_000_000),
    Unit("min", "time", times=60),
    Unit("m", "length"),
    Unit("cm", "length", over=100),
    Unit("mm", "length", over=1_000),
    Unit("um", "length", over=1_000_000),
    Unit("m/s", "velocity"),
    Unit("cm/s", "velocity", over=100),
    Unit("mm/s", "velocity", over=1_000),
    Unit("m/s2", "acceleration"),
    Unit("cm/s2", "acceleration", over=100),
    Unit("mm/s2", "acceleration", over=1_000),
    Unit("N", "force"),
    Unit("mN", "force", over=1_000),
    Unit("kN", "force", times=1_000),
    Unit("1", "number"),
    Unit("%", "number", over=100),
    Unit("rad", "angle"),
    Unit("deg", "angle", times=math.pi, over=180),
    Unit("rad/s", "angular velocity"),
    Unit("deg/s", "angular velocity", times=math.pi, over=180),
    Unit("rad/s2", "angular acceleration"),
    Unit("deg/s2", "angular acceleration", times=math.pi, over=180),
    Unit("N m", "torque"),
    Unit("N mm", "torque", over=1_000),
)
UNITS = {unit.symbol: unit for unit in _UNITS}
SI = {unit.quantity: unit for unit in reversed(_UNITS) if unit.times == unit.over}
# what a file's inDegrees is about
IN_DEGREES = {unit.quantity: unit for unit in _UNITS if unit.symbol.startswith("deg")}

_SPELLINGS = str.maketrans({"²": "2", "^": "", "*": "", "µ": "u", "μ": "u", " ": ""})
_WORDS = {"": "1", "-": "1", "sec": "s", "m/s/s": "m/s2", "Nm": "N m", "Nmm": "N mm"}
_WORDS |= {"°": "deg", **dict.fromkeys(("degree", "degrees"), "deg"), **dict.fromkeys(("radian", "radians"), "rad")}


def find_unit(text: str) -> Unit | None:
    """The unit that a text names, if it names one."""
    plain = text.translate(_SPELLINGS)
    return UNITS.get(_WORDS.get(plain, plain))


def unit_of(text: str, quantity: str, where: str) -> Unit:
    """The unit `text` for a quantity. RecordingError if there is no such unit, or it measures something else."""
    unit = find_unit(text)
    valid = ", ".join(known.symbol for known in _UNITS if known.quantity == quantity)
    if unit is None:
        raise RecordingError(f"{where}: unknown unit {shown(text)}; {_a(quantity)} is in {valid}")
    if unit.quantity != quantity:
        raise RecordingError(f"{where}: {unit.symbol} is the unit of {_a(unit.quantity)}; {_a(quantity)} is in {valid}")
    return unit


def _a(quantity: str) -> str:
    return f"{'an' if quantity[0] in 'aeiou' else 'a'} {quantity}"
