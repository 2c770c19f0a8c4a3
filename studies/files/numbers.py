"""Numbers of others, strictly: in the texts of files and command lines, and in the arguments of Python calls."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from numbers import Integral
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ...model.arrays import Array, is_number
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
SMALLEST, LARGEST = 1e-30, 1e30
_LARGEST_SEED = 2**64 - 1


def typed_whole(option: str, text: str, least: int, most: int | None = None) -> int:
    """The whole number that an option is given as typed. ScenarioError if it is none, or out of bounds."""
    plain = int(text) if text.isascii() and text.isdigit() and len(text) <= _MOST_DIGITS else least - 1
    if not least <= plain <= (plain if most is None else most):
        raise ScenarioError(f"{option} must be a whole number {_bounds(least, most)}, not {shown(text)}")
    return plain


def parse_number(what: str, text: str) -> float:
    """A finite number as typed: digits, point, exponent. ScenarioError says what is not one."""
    if not NUMBER.fullmatch(text):
        raise ScenarioError(f"{short(what)} must be a number, not {shown(text)}")
    return number(short(what), float(text))


def number(what: str, value: object) -> float:
    """A finite number of Python or NumPy. ScenarioError for all else, texts and truth values included."""
    if not is_number(value):
        raise ScenarioError(f"{what} must be a number, not {shown(value)}")
    try:
        plain = float(value)
    except OverflowError:
        plain = math.inf
    if not math.isfinite(plain):
        raise ScenarioError(f"{what} must be a finite number, not {plain}")
    return plain


def whole(what: str, value: object, least: int, most: int | None = None) -> int:
    """A whole number of Python or NumPy. ScenarioError for all else, truth values and 1.0 included."""
    plain = int(value) if is_number(value) and isinstance(value, Integral) else None
    if plain is None or plain < least or (most is not None and plain > most):
        raise ScenarioError(f"{what} must be a whole number {_bounds(least, most)}, not {shown(value)}")
    return plain


def numbers(what: str, values: object, most: int) -> Array:
    """(n) the finite numbers of a sequence, or a number alone. ScenarioError for all else, and for n above `most`."""
    return _column(what, [values] if is_number(values) else values, most, float, number)


def seeds(what: str, values: object, most: int) -> NDArray[np.uint64]:
    """(n) the whole numbers of a sequence, each a seed. ScenarioError as above."""
    return _column(what, values, most, np.uint64, seed)


def seed(what: str, value: object) -> int:
    """A whole number from 0 to 2⁶⁴ − 1. ScenarioError for all else."""
    return whole(what, value, 0, _LARGEST_SEED)


def samples(what: str, values: object, most: int) -> Array:
    """(n) an array of numbers, NaN where there is none or a mask hides it.

    ScenarioError for all else, and for n above `most`.
    """
    if not isinstance(values, np.ndarray) or values.ndim != 1 or values.dtype.kind not in "iuf":
        raise ScenarioError(f"{what} must be an array of numbers in one dimension, not {shown(values)}")
    if values.size > most:
        raise ScenarioError(f"{what} has {values.size:,} values, more than {most:,}")
    plain: Array = values.astype(float, copy=False)
    if isinstance(plain, np.ma.MaskedArray):
        plain = plain.filled(np.nan)
    if np.isinf(plain).any():
        raise ScenarioError(f"{what} must be finite numbers, or NaN where there is none")
    return plain


def switch(what: str, value: object) -> bool:
    """A truth value. ScenarioError if it is anything else."""
    if not isinstance(value, bool | np.bool_):
        raise ScenarioError(f"{what} must be true or false, not {shown(value)}")
    return bool(value)


def within(path: str, value: object, parameter: Parameter) -> float:
    """`value` as a number within the bounds of `parameter`. ScenarioError names `path` and says what it must be."""
    plain = number(path, value)
    if objection := parameter.objection(plain):
        raise ScenarioError(f"{path} must be {objection}, not {plain:.12g}")
    if plain and not SMALLEST <= abs(plain) <= LARGEST:
        raise ScenarioError(f"{path} must be 0 or from {SMALLEST:g} to {LARGEST:g} in magnitude, not {plain:g}")
    return plain


def _column(
    what: str, values: object, most: int, dtype: type[Any], checked: Callable[[str, object], float]
) -> NDArray[Any]:
    """(n) the values of a sequence, `checked` one by one; its size is looked at first."""
    # arrays of xarray and pandas too, but none of objects
    is_array = getattr(values, "ndim", 0) == 1 and getattr(getattr(values, "dtype", None), "kind", "O") != "O"
    if not (is_array or isinstance(values, Sequence)) or isinstance(values, str | bytes):
        raise ScenarioError(f"{what} must be a list of numbers, not {shown(values)}")
    # a mask stays: what it hides is no number
    column = np.asanyarray(values) if is_array else cast(Sequence[object], values)
    if not 1 <= len(column) <= most:
        raise ScenarioError(f"{what}: there must be 1 to {most:,} values, not {len(column):,}")
    return np.fromiter((checked(what, value) for value in column), dtype, len(column))


def _bounds(least: int, most: int | None) -> str:
    if most == _LARGEST_SEED:
        return f"from {least} to 2⁶⁴ − 1"
    return f"of at least {least:,}" if most is None else f"from {least:,} to {most:,}"
