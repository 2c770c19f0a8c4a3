"""How far a number of a muscle may be off: a standard deviation in its unit, in another one, or as a part of it."""

from __future__ import annotations

import re

from ..files.errors import ScenarioError
from ..files.numbers import NUMBER, number
from ..files.quote import shown
from .units import UNITS, find_unit

# the number first, however long: what is left of 1e5 is no unit
_WITH_UNIT = re.compile(rf"(?P<number>(?>{NUMBER.pattern}))\s*(?P<unit>\D.*)", re.ASCII)
_PERCENT = "%"


def deviation(path: str, given: object, value: float, unit: str) -> float:
    """The standard deviation, in `unit`, of the number at `path`, which is `value`.

    given: a number in that unit, or a text such as 3% or 0.1mm. ScenarioError if it is neither, not above 0, or more
    than the number itself.
    """
    sd = number(f"the sd of {path}", given) if not isinstance(given, str) else _typed(path, given, value, unit)
    if not sd > 0:
        raise ScenarioError(f"the sd of {path} must be above 0, not {shown(given)}")
    if value and sd > abs(value):
        raise ScenarioError(
            f"the sd of {path}, {sd:g} {unit}, is more than the number itself, {value:g}; a part of it is written 3%"
        )
    return sd


def _typed(path: str, text: str, value: float, unit: str) -> float:
    match = _WITH_UNIT.fullmatch(text.strip())
    if match is None:
        raise ScenarioError(f"the sd of {path} must be a number, or a text such as 3%, not {shown(text)}")
    plain, symbol = number(f"the sd of {path}", float(match["number"])), match["unit"]
    if symbol == _PERCENT:
        if not value:
            raise ScenarioError(f"the sd of {path} must be a number, not a part of it, {shown(text)}: it is 0")
        return plain / 100 * abs(value)
    if symbol == unit:
        return plain
    given, own = find_unit(symbol), UNITS.get(unit)
    if given is None or own is None or given.quantity != own.quantity:
        words = "in %, or a number without a unit" if unit == "1" else f"in {unit} or in %"
        raise ScenarioError(f"the sd of {path} must be {words}, not {shown(text)}")
    return plain * given.times / given.over
