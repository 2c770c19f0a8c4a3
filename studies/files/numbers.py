"""Numbers in the texts of others: one strict pattern, and the cells of a table by it."""

from __future__ import annotations

import math
import re
from numbers import Real

from ...model.block import Parameter
from .errors import ScenarioError
from .quote import short, shown

# no blanks, no underscores, no digits of other scripts, no inf, no hexadecimals
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# what C, NumPy and pandas write where there is no number
GAP = re.compile(r"([+-]?nan)?", re.IGNORECASE | re.ASCII)
# of a whole number on a command line
_MOST_DIGITS = 12
# no quantity of a muscle, in any unit, is beyond these; a product of ten such numbers is a number still
_SMALLEST, _LARGEST = 1e-30, 1e30


def whole_number(option: str, text: str, least: int) -> int:
    """The whole number that an option is given as typed. ScenarioError if it is none, or below `least`."""
    if not text.isascii() or not text.isdigit() or len(text) > _MOST_DIGITS or int(text) < least:
        raise ScenarioError(f"{option} must be a whole number of at least {least}, not {shown(text)}")
    return int(text)


def parse_number(what: str, text: str) -> float:
    """A number as typed: digits, point, exponent. ScenarioError says what is not one."""
    if not NUMBER.fullmatch(text):
        raise ScenarioError(f"{short(what)} must be a number, not {shown(text)}")
    return float(text)


def within(path: str, value: object, parameter: Parameter) -> float:
    """`value` as a number within the bounds of `parameter`. ScenarioError names `path` and says what it must be."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ScenarioError(f"{path} must be a number, not {shown(value)}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ScenarioError(f"{path} must be a finite number, not {number}")
    if number and not _SMALLEST <= abs(number) <= _LARGEST:
        raise ScenarioError(f"{path} must be 0 or from {_SMALLEST:g} to {_LARGEST:g} in magnitude, not {number:g}")
    if objection := parameter.objection(number):
        raise ScenarioError(f"{path} must be {objection}, not {number:.12g}")
    return number
