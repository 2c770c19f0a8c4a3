"""Scenarios: what is simulated, as TOML, checked leaf by leaf against the table of all numbers."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from numbers import Integral
from pathlib import Path

from ...model.curves import CURVES, SIMULATED, Curves
from ...model.pair import DRIVES
from ...model.symbols import MUSCLES
from ..files.errors import ScenarioError, TomlError
from ..files.numbers import parse_number, within
from ..files.quote import short, shown
from ..files.toml import read_toml
from .paths import Table

_SHIPPED = "hillobs.studies.scenarios"
# the paper's two first, then the harder ones
_ORDER = ("paper-clean", "paper-noisy", "challenge", "slack", "slack-deep", "activation")
_DEEPEST = 8
_LARGEST_SEED = 2**64 - 1

_WHOLE = re.compile(r"[+-]?\d{1,20}", re.ASCII)
# what a result cannot carry: the end of a C string, and halves of characters
_NO_TEXT = re.compile(r"[\0\ud800-\udfff]")

Value = float | str | bool
Numbers = Mapping[str, float]

# the keys of a scenario that are no numbers, and what they may be; the first is the default
CHOICES: Mapping[str, tuple[str, ...]] = {
    "plant.drive": tuple(DRIVES),
    **{f"{muscle}.curves": SIMULATED for muscle in MUSCLES},
}
# several at once, before those of one muscle
_GROUPED = {"muscle.curves": tuple(f"{muscle}.curves" for muscle in MUSCLES)}


@dataclass(frozen=True)
class Scenario:
    """A name, a sentence, the choices, and the numbers that differ from the defaults, by path."""

    name: str
    description: str = ""
    seed: int = 0
    choices: Mapping[str, str] = field(default_factory=dict)
    given: Numbers = field(default_factory=dict)

    @property
    def drive(self) -> str:
        """How the plant is driven."""
        return self.choices.get("plant.drive", "virtual")

    @property
    def curves(self) -> Curves:
        """The curve sets of both muscles."""
        return curves_of(self.choices)


def shipped() -> dict[str, str]:
    """The scenarios that come with hillobs: name → TOML."""
    files = [file for file in resources.files(_SHIPPED).iterdir() if file.name.endswith(".toml")]
    texts = {file.name.removesuffix(".toml"): file.read_text(encoding="utf-8") for file in files}
    return {name: texts[name] for name in sorted(texts, key=lambda name: (name not in _ORDER, _place(name), name))}


def read(source: str | Path) -> tuple[str, dict[str, object]]:
    """Name and content of a shipped scenario or of a TOML file. ScenarioError says what is wrong, and where."""
    texts = shipped()
    name = str(source)
    if name in texts:
        return name, tomllib.loads(texts[name])
    path = Path(name)
    if path.suffix != ".toml":
        raise ScenarioError(f"unknown scenario {shown(name)}; there are {', '.join(texts)}, or name a .toml file")
    try:
        content = read_toml(path)
    except TomlError as error:
        raise ScenarioError(str(error)) from error
    return _text(f"{path}: its name", path.stem), content


def curves_of(choices: Mapping[str, str]) -> Curves:
    """The curve sets that the choices of a scenario or of a result name."""
    first, second = (CURVES[choices.get(path, SIMULATED[0])] for path in _GROUPED["muscle.curves"])
    return first if first is second else (first, second)


def choices_in(content: Mapping[str, object], changes: Mapping[str, Value]) -> dict[str, str]:
    """The choices of a TOML document with `changes` on top. ScenarioError names what is wrong with one."""
    choices: dict[str, str] = {}
    for layer in (_leaves(content, lambda path: True), changes):
        for group, members in (*_GROUPED.items(), *((path, (path,)) for path in CHOICES)):
            if group in layer:
                choices |= dict.fromkeys(members, _choice(group, layer[group], CHOICES[members[0]]))
    return choices


def scenario(name: str, content: Mapping[str, object], changes: Mapping[str, Value], table: Table) -> Scenario:
    """The scenario of a TOML document with `changes` (path → value) on top. ScenarioError names the wrong leaf."""
    description, seed = "", 0
    given: dict[str, float] = {}
    for layer in (_leaves(content, table.is_section), changes):
        numbers: dict[str, float] = {}
        for path, value in layer.items():
            if not isinstance(path, str):
                raise ScenarioError(f"a path must be a text such as plant.m, not {shown(path)}")
            if path == "description":
                description = _text(path, value)
            elif path == "seed":
                seed = _seed(value)
            elif not is_choice(path):
                numbers[path] = checked_number(path, value, table)
        given |= table.spread(numbers)
    return Scenario(name, description, seed, choices_in(content, changes), given)


def parse_change(text: str) -> tuple[str, Value]:
    """`PATH=VALUE` as typed on a command line."""
    path, equals, value = text.partition("=")
    if not equals or not path:
        raise ScenarioError(f"{shown(text)} is not PATH=VALUE, such as plant.m=1.2")
    if is_choice(path) or path == "description":
        return path, value
    number = parse_number(path, value)
    return path, number if path != "seed" else _whole(value)


def is_choice(path: str) -> bool:
    """Whether the value of a path is one of some names, no number."""
    return path in CHOICES or path in _GROUPED


def _leaves(content: Mapping[str, object], is_section: Callable[[str], bool]) -> dict[str, object]:
    """Path → value of each leaf of nested tables; an empty table is a leaf unless paths lie below it."""
    leaves: dict[str, object] = {}
    stack = list(content.items())[::-1]
    while stack:
        path, value = stack.pop()
        if path.count(".") > _DEEPEST:
            raise ScenarioError(f"{shown(path)} is nested too deeply; paths are such as high_gain.muscle1.k")
        if path in leaves:
            raise ScenarioError(f"{short(path)} is given twice")
        if isinstance(value, dict) and (value or is_section(path)):
            stack += [(f"{path}.{key}", inner) for key, inner in value.items()][::-1]
        else:
            leaves[path] = value
    return leaves


def checked_number(path: str, value: object, table: Table) -> float:
    """The number at `path`, within the bounds of its parameter. ScenarioError says what it must be."""
    return within(path, value, table.paths[table.expand(path)[0]])


def _choice(path: str, value: object, valid: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in valid:
        raise ScenarioError(f"{path} must be one of {', '.join(valid)}, not {shown(value)}")
    return value


def _text(path: str, value: object) -> str:
    if not isinstance(value, str):
        raise ScenarioError(f"{path} must be a text, not {shown(value)}")
    if _NO_TEXT.search(value):
        raise ScenarioError(f"{path} must be a text of whole characters without \\0, not {shown(value)}")
    return value


def _seed(value: object) -> int:
    whole = int(value) if isinstance(value, Integral) and not isinstance(value, bool) else -1
    if not 0 <= whole <= _LARGEST_SEED:
        raise ScenarioError(f"seed must be a whole number from 0 to 2⁶⁴ − 1, not {shown(value)}")
    return whole


def _whole(text: str) -> Value:
    return int(text) if _WHOLE.fullmatch(text) else float(text)


def _place(name: str) -> int:
    return _ORDER.index(name) if name in _ORDER else len(_ORDER)
