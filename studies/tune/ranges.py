"""What a search may change: numbers of an observer, each within a range."""

from __future__ import annotations

from ...model.block import Parameter
from ...observers import Observer
from ..files.errors import ScenarioError
from ..files.numbers import LARGEST, SMALLEST
from ..scenarios.prepare import Prepared
from ..sweep.axes import Range

# a number may become so many times larger or smaller: the paper's filters are 30 times too fast for its noise
SPAN = 30.0
# a bound that is itself no value is left alone by so much of what lies between
_OFF = 1e-3


def usual_ranges(prepared: Prepared, observer: Observer, name: str) -> dict[str, Range]:
    """Path → range of what the observer called `name` has to tune, about the scenario's own numbers.

    Numbers that several joints or muscles have are one. ScenarioError if there are none.
    """
    block = observer.block(prepared.corrected, prepared.system)
    paths = [
        f"{name}.{number}"
        for number, parameter in block.parameters.items()
        if _is_gain(observer, number, parameter) and prepared.value(f"{name}.{number}") > 0
    ]
    if not paths:
        raise ScenarioError(f"{name} has no numbers to tune; name some with over (--over PATH=log:LOW:HIGH)")
    return {path: _about(prepared, path) for path in _together(prepared, paths)}


def _is_gain(observer: Observer, number: str, parameter: Parameter) -> bool:
    """One that the registry names; of an observer that is not there, any of its own."""
    words = number.split(".")
    if observer.tuned:
        return words[-1] in observer.tuned
    return "initial" not in words and not parameter.whole and not parameter.shared


def _together(prepared: Prepared, paths: list[str]) -> list[str]:
    """The paths, those of a group by its name."""
    group_of = {
        member: group
        for group in prepared.paths.groups()
        for members in [prepared.paths.expand(group)]
        if set(members) <= set(paths)
        for member in members
    }
    return list(dict.fromkeys(group_of.get(path, path) for path in paths))


def _about(prepared: Prepared, path: str) -> Range:
    first = prepared.paths.expand(path)[0]
    parameter, value = prepared.paths.parameters[first], prepared.value(first)
    bounds = max(parameter.above, 0.0), min(parameter.below, LARGEST)
    above, below = (bound + _OFF * (value - bound) for bound in bounds)
    low, high = max(value / SPAN, parameter.least, above, SMALLEST), min(value * SPAN, parameter.most, below)
    return Range(low, high, logarithmic=True)
