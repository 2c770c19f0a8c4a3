"""Words of others: short and on one line in a sentence, harmless to a terminal and on paper, fit to be stored."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from .errors import ScenarioError

# what a result cannot carry: the end of a C string, and halves of characters
_NO_TEXT = re.compile(r"[\0\ud800-\udfff]")

_HALF = 60
_DIGITS = 10**40


def escaped(text: str) -> str:
    r"""`text` with every character that cannot be printed as an escape, such as \n."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def drawn(text: str) -> str:
    """`text` for a figure: what would be mathematics between dollars stays dollars."""
    return escaped(text).replace("$", r"\$")


def text(what: str, value: object) -> str:
    """`value` as a text that a result can carry. ScenarioError says what is none."""
    if not isinstance(value, str):
        raise ScenarioError(f"{what} must be a text, not {shown(value)}")
    if _NO_TEXT.search(value):
        raise ScenarioError(f"{what} must be a text of whole characters without \\0, not {shown(value)}")
    return value


def table(what: str, value: object) -> dict[str, Any]:
    """`value` as a dict whose keys are texts. ScenarioError if it is none."""
    if not isinstance(value, Mapping):
        raise ScenarioError(f"{what} must be a dict, not {shown(value)}")
    if odd := [key for key in value if not isinstance(key, str)]:
        raise ScenarioError(f"a name in {what} must be a text such as plant.m, not {shown(odd[0])}")
    return dict(value)


def short(text: str) -> str:
    """`text`, of a long one only both ends."""
    return text if len(text) <= 2 * _HALF else f"{text[:_HALF]}…{text[-_HALF:]}"


def shown(value: object) -> str:
    """A value much as TOML writes it, cut short."""
    match value:
        case str():
            text = repr(short(value))
        case bool():
            text = str(value).lower()
        case int() if abs(value) > _DIGITS:  # Python refuses to print the longest
            text = "a number of many digits"
        case list():
            text = f"[{', '.join(map(shown, value[:_HALF]))}]"
        case dict():
            text = "a table"
        case _:
            text = str(value)
    return short(escaped(text))


def ranges(numbers: Iterable[int], most: int = 5) -> str:
    """Whole numbers that rise, with neighbours joined, such as 3–5, 9; of many, how many follow."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][1] + 1:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    words = [f"{first}–{last}" if last > first else f"{first}" for first, last in runs[:most]]
    more = sum(last - first + 1 for first, last in runs[most:])
    return ", ".join(words) + (f" and {more:,} more" if more else "")
