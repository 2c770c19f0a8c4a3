"""The layers of a scenario: path → value as written, each with the place that is to blame for it."""

from __future__ import annotations

import contextlib
import functools
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from ..files.errors import ScenarioError, in_file
from ..files.quote import short, shown, table, text
from ..files.toml import read_toml

_SHIPPED = "hillobs.studies.scenarios"
# the paper's two first, then the harder ones
_ORDER = ("paper-clean", "paper-noisy", "tuned", "challenge", "slack", "slack-deep", "activation")
# the key of a file that names the shipped scenario below it
_BASE = "base"
_DEEPEST = 8
# of a file of numbers
SUFFIX = ".toml"

Value = float | str | bool


@dataclass(frozen=True)
class Layer:
    """Path → value of each leaf, and where they stand: a scenario or a file, or "" for changes beside it."""

    origin: str
    leaves: Mapping[str, object]

    def blamed(self) -> contextlib.AbstractContextManager[None]:
        """What is wrong with a leaf is said with the name of the layer."""
        return in_file(self.origin) if self.origin else contextlib.nullcontext()


@functools.cache
def shipped() -> Mapping[str, str]:
    """The scenarios that come with hillobs: name → TOML."""
    files = [file for file in resources.files(_SHIPPED).iterdir() if file.name.endswith(".toml")]
    texts = {file.name.removesuffix(".toml"): file.read_text(encoding="utf-8") for file in files}
    return {name: texts[name] for name in sorted(texts, key=lambda name: (name not in _ORDER, _place(name), name))}


def layers(source: str | Path, changes: Mapping[str, Value]) -> tuple[str, list[Layer]]:
    """Name and layers, the lowest first: of a shipped scenario or of a TOML file with its base, then `changes`.

    ScenarioError if there is no such scenario, or the file cannot be read.
    """
    name, top = str(source), Layer("", table("changes", changes))
    if name in shipped():
        return name, [_shipped_layer(name), top]
    path = Path(name)
    if path.suffix != SUFFIX:
        raise ScenarioError(f"unknown scenario {shown(name)}; there are {', '.join(shipped())}, or name a .toml file")
    content = read_toml(path)
    base = content.pop(_BASE, None)
    if base is not None and (not isinstance(base, str) or base not in shipped()):
        raise ScenarioError(f"{path}: {_BASE} must be one of {', '.join(shipped())}, not {shown(base)}")
    below = [] if base is None else [_shipped_layer(base)]
    return text(f"{path}: its name", path.stem), [*below, layer(name, content), top]


def written(source: str | Path, changes: Mapping[str, Value]) -> dict[str, object]:
    """What a file of this scenario has to say: path → value, and its base. ScenarioError as for `layers`."""
    said: dict[str, object] = {}
    for one in layers(source, changes)[1]:
        said |= {_BASE: one.origin} if one.origin in shipped() else one.leaves
    return said


def changes_of(path: str) -> dict[str, Any]:
    """Path → value of a .toml file that is no scenario of its own. ScenarioError if it cannot be read, or is one."""
    content = read_toml(Path(path))
    if _BASE in content:
        raise ScenarioError(f"{path}: it has a {_BASE}, so it is a scenario to be run, not numbers to be set")
    return dict(layer(path, content).leaves)


def layer(origin: str, content: Mapping[str, object]) -> Layer:
    """The layer of a TOML document. ScenarioError if a leaf is given twice or lies too deep."""
    leaves: dict[str, object] = {}
    flat = Layer(origin, leaves)
    with flat.blamed():
        leaves |= _leaves(content)
    return flat


def _shipped_layer(name: str) -> Layer:
    return layer(name, tomllib.loads(shipped()[name]))


def _leaves(content: Mapping[str, object]) -> dict[str, object]:
    """Path → value of each leaf of nested tables; an empty table is a leaf."""
    leaves: dict[str, object] = {}
    stack = list(content.items())[::-1]
    while stack:
        path, value = stack.pop()
        if path.count(".") > _DEEPEST:
            raise ScenarioError(f"{shown(path)} is nested too deeply; paths are such as high_gain.muscle1.k")
        if path in leaves:
            raise ScenarioError(f"{short(path)} is given twice")
        if isinstance(value, dict) and value:
            stack += [(f"{path}.{key}", inner) for key, inner in value.items()][::-1]
        else:
            leaves[path] = value
    return leaves


def _place(name: str) -> int:
    return _ORDER.index(name) if name in _ORDER else len(_ORDER)
