"""Tables of a TOML file: which keys there are, and their numbers with or without a standard deviation."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping

from ....model.block import Parameter
from ...files.errors import ScenarioError
from ...files.numbers import within
from ...files.quote import short, shown
from ..deviations import deviation

# a number with its standard deviation, as a file has it
_VALUE, _SD = "value", "sd"


def section(content: Mapping[str, object], name: str, prefix: str = "") -> dict[str, object]:
    """The table of this name, empty if there is none. ScenarioError if it is something else."""
    found = content.get(name, {})
    if not isinstance(found, dict):
        raise ScenarioError(f"{prefix}{name} must be a table, [{prefix}{name}], not {shown(found)}")
    return found


def refuse_unknown(given: Iterable[str], known: list[str], prefix: str) -> None:
    """ScenarioError for a key that is not `known`, with those that look like it."""
    for key in given:
        if key not in known:
            near = difflib.get_close_matches(short(key), known, n=3) or known
            raise ScenarioError(
                f"unknown key {shown(prefix + key)}; the nearest are {', '.join(prefix + name for name in near)}"
            )


def refuse_missing(missing: list[str]) -> None:
    """ScenarioError if any key is missing."""
    if missing:
        raise ScenarioError(f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing")


def numbers(
    given: Mapping[str, tuple[object, str]], known: Mapping[str, Parameter]
) -> tuple[dict[str, float], dict[str, float]]:
    """Values, and standard deviations of those that have one, of numbers or tables with both.

    given: the content of each key and the path by which a sentence names it.
    """
    values: dict[str, float] = {}
    sds: dict[str, float] = {}
    for key, (content, path) in given.items():
        value = content
        if isinstance(content, dict):
            if list(content) == [_VALUE]:
                raise ScenarioError(f"{path} has a value without an sd; a number without one stands alone")
            if sorted(content) != [_SD, _VALUE]:
                raise ScenarioError(f"{path} must be a number, or {{ value = …, sd = … }}, not {shown(content)}")
            value = content[_VALUE]
        values[key] = within(path, value, known[key])
        if isinstance(content, dict):
            sds[key] = deviation(path, content[_SD], values[key], known[key].unit)
    return values, sds


def with_sds(values: Mapping[str, float], sds: Mapping[str, float]) -> dict[str, object]:
    """The same as a file has them."""
    return {key: {_VALUE: value, _SD: sds[key]} if key in sds else value for key, value in values.items()}
