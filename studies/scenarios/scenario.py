"""Scenarios: what is simulated, checked leaf by leaf against the table of all numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ...model.curves import CURVES, SIMULATED, Curves
from ...model.plant import DRIVES
from ...model.symbols import MUSCLES
from ..files.errors import ScenarioError
from ..files.numbers import parse_number, within
from ..files.numbers import seed as checked_seed
from ..files.quote import shown, text
from .layers import SUFFIX, Layer, Value, changes_of
from .paths import Paths

_WHOLE = re.compile(r"[+-]?\d{1,20}", re.ASCII)

Numbers = Mapping[str, float]

# the keys of a scenario that are no numbers, and what they may be; the first is the default
CHOICES: Mapping[str, tuple[str, ...]] = {
    "plant.drive": tuple(DRIVES),
    **{f"{muscle}.curves": SIMULATED for muscle in MUSCLES},
}
# several at once, before those of one muscle
_GROUPED = {"muscle.curves": tuple(f"{muscle}.curves" for muscle in MUSCLES)}
# each path whose value is one of some names, with these names; groups too
VALID_CHOICES: Mapping[str, tuple[str, ...]] = {
    **CHOICES,
    **{group: CHOICES[members[0]] for group, members in _GROUPED.items()},
}


@dataclass(frozen=True)
class Scenario:
    """A name, a sentence, the choices, and the numbers that are given, by path; `changes` are those beside its file."""

    name: str
    description: str = ""
    seed: int = 0
    choices: Mapping[str, str] = field(default_factory=dict)
    given: Numbers = field(default_factory=dict)
    changes: Mapping[str, object] = field(default_factory=dict)

    @property
    def drive(self) -> str:
        """How the plant is driven."""
        return self.choices.get("plant.drive", "virtual")

    @property
    def curves(self) -> Curves:
        """The curve sets of both muscles."""
        return curves_of(self.choices)


def curves_of(choices: Mapping[str, str]) -> Curves:
    """The curve sets that the choices of a scenario or of a result name."""
    first, second = (CURVES[choices.get(path, SIMULATED[0])] for path in _GROUPED["muscle.curves"])
    return first if first is second else (first, second)


def choices(layers: Sequence[Layer]) -> dict[str, str]:
    """The choices of the layers, the last one above. ScenarioError names what is wrong with one, and its layer."""
    chosen: dict[str, str] = {}
    for layer in layers:
        with layer.blamed():
            for group, members in (*_GROUPED.items(), *((path, (path,)) for path in CHOICES)):
                if group in layer.leaves:
                    chosen |= dict.fromkeys(members, _choice(group, layer.leaves[group]))
    return chosen


def scenario(name: str, layers: Sequence[Layer], paths: Paths) -> Scenario:
    """The scenario of the layers, the last one above. ScenarioError names the wrong leaf, and its layer."""
    description, seed = "", 0
    given: dict[str, float] = {}
    for layer in layers:
        with layer.blamed():
            numbers: dict[str, float] = {}
            for path, value in layer.leaves.items():
                if path == "description":
                    description = text(path, value)
                elif path == "seed":
                    seed = checked_seed(path, value)
                elif path not in VALID_CHOICES and not _is_empty_section(path, value, paths):
                    numbers[path] = checked_number(path, value, paths)
            given |= paths.spread(numbers)
    changes = {path: value for layer in layers if not layer.origin for path, value in layer.leaves.items()}
    return Scenario(name, description, seed, choices(layers), given, changes)


def typed_changes(typed: str) -> dict[str, Value]:
    """`PATH=VALUE` as typed on a command line, or the name of a .toml file with such numbers: path → value."""
    return changes_of(typed) if typed.endswith(SUFFIX) and "=" not in typed else dict([parse_change(typed)])


def parse_change(typed: str) -> tuple[str, Value]:
    """`PATH=VALUE` as typed on a command line."""
    path, equals, value = typed.partition("=")
    if not equals or not path:
        raise ScenarioError(f"{shown(typed)} is not PATH=VALUE, such as plant.m=1.2")
    if path in VALID_CHOICES or path == "description":
        return path, value
    number = parse_number(path, value)
    return path, number if path != "seed" else _whole(value)


def checked_number(path: str, value: object, paths: Paths) -> float:
    """The number at `path`, within the bounds of its parameter. ScenarioError says what it must be."""
    return within(path, value, paths.parameters[paths.expand(path)[0]])


def _is_empty_section(path: str, value: object, paths: Paths) -> bool:
    return isinstance(value, dict) and not value and paths.is_section(path)


def _choice(path: str, value: object) -> str:
    valid = VALID_CHOICES[path]
    if not isinstance(value, str) or value not in valid:
        raise ScenarioError(f"{path} must be one of {', '.join(valid)}, not {shown(value)}")
    return value


def _whole(typed: str) -> Value:
    return int(typed) if _WHOLE.fullmatch(typed) else float(typed)
