"""Words of others inside our sentences: short, on one line, harmless to a terminal."""

from __future__ import annotations

from collections.abc import Iterable

_HALF = 60
_DIGITS = 10**40


def escaped(text: str) -> str:
    r"""`text` with every character that cannot be printed as an escape, such as \n."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


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
