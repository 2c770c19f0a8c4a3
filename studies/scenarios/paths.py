"""The paths of all numbers of a scenario: each with its parameter, and the Block that takes it."""

from __future__ import annotations

import difflib
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from ...model.block import Block, Parameter
from ...model.signals.pulses import PULSES
from ...model.symbols import MUSCLES
from ..files.errors import ScenarioError
from ..files.quote import short, shown

_CHOSEN = "chosen, docs/model.md#scenarios"

# numbers of the run itself; everything else is a parameter of a Block
TIMES: Mapping[str, Parameter] = {
    "duration": Parameter(20.0, "length of the run", "paper, §V", above=0),
    "step": Parameter(
        5e-4, "integration step of RK4; divides noise.period and record", "chosen, docs/model.md#integration", above=0
    ),
    "record": Parameter(0.01, "time between recorded points", "chosen, docs/model.md#integration", above=0),
    "score.start": Parameter(2.0, "errors count from here on", "chosen, docs/model.md#measures", least=0),
    "noise.period": Parameter(
        0.005, "T_s, how long a noise sample is held; 0 switches the noise off", "paper", least=0
    ),
}
# of a run of the pair
RUN: Mapping[str, Parameter] = {
    **TIMES,
    **{f"{name}.start": Parameter(0.0, f"{name} begins", _CHOSEN, least=0) for name in PULSES},
    **{f"{name}.stop": Parameter(0.0, f"{name} ends", _CHOSEN, least=0) for name in PULSES},
}

# `muscle.k` is both `muscle1.k` and `muscle2.k`
Groups = Mapping[str, tuple[str, ...]]
_GROUPS: Groups = {"muscle": MUSCLES, "pulse": PULSES}


@dataclass(frozen=True)
class Paths:
    """All paths of a scenario, for some Blocks; the values of a Block are in the order of its `p`.

    run: the numbers of the run itself. members: a name such as `muscle` → all that it stands for in a path.
    """

    blocks: tuple[Block, ...]
    parameters: Mapping[str, Parameter]
    run: Mapping[str, Parameter]
    members: Groups

    def expand(self, path: str) -> list[str]:
        """The paths that `path` stands for; ScenarioError with the nearest valid names if there is none."""
        if path in self.parameters:
            return [path]
        parts = path.split(".")
        for group, members in self.members.items():
            if group in parts:
                at = parts.index(group)
                paths = [".".join([*parts[:at], member, *parts[at + 1 :]]) for member in members]
                if all(name in self.parameters for name in paths):
                    return paths
        raise ScenarioError(f"unknown path {shown(path)}; the nearest are {', '.join(self.nearest(path))}")

    def spread(self, values: Mapping[str, float]) -> dict[str, float]:
        """The values by the paths that theirs stand for; `muscle1.k` wins over `muscle.k`."""
        result: dict[str, float] = {}
        for path in sorted(values, key=lambda path: -len(self.expand(path))):
            result |= dict.fromkeys(self.expand(path), values[path])
        return result

    def is_run(self, path: str) -> bool:
        """Whether it is a number of the run itself, which decides the time grid."""
        return self.expand(path)[0] in self.run

    def nearest(self, path: str) -> list[str]:
        """Paths that look like `path`, best first; if none does, those that end alike."""
        known = [*self.parameters, *self.groups()]
        close = difflib.get_close_matches(short(path), known, n=3)
        last = path.rpartition(".")[2]
        return close or [name for name in known if name.rpartition(".")[2] == last][:3] or list(self.run)

    def is_section(self, path: str) -> bool:
        """Whether there are paths below `path`, such as those of `[plant]`."""
        return any(known.startswith(f"{path}.") for known in (*self.parameters, *self.groups()))

    def groups(self) -> dict[str, Parameter]:
        """The paths that set several numbers at once, and what they set."""
        return {
            path.replace(first, group, 1): parameter
            for group, (first, *others) in self.members.items()
            for path, parameter in self.parameters.items()
            if first in path.split(".") and all(path.replace(first, one, 1) in self.parameters for one in others)
        }

    def value(self, path: str, given: Mapping[str, float]) -> float:
        """The number at `path`: given, else the one it shares, else its default."""
        origin = self.origin(path, given)
        return given.get(origin, self.parameters[origin].default)

    def origin(self, path: str, given: Container[str]) -> str:
        """The path whose number `path` takes, where numbers are given at some paths: its own, or one that it shares."""
        shared = self.parameters[path].shared
        if path in given or not shared or shared == path or shared not in self.parameters:
            return path
        return self.origin(shared, given)

    def values(self, block: Block, given: Mapping[str, float]) -> list[float]:
        """The numbers of `block`."""
        return [self.value(path, given) for path in block_paths(block)]


def paths_of(
    blocks: Iterable[Block],
    run: Mapping[str, Parameter] = RUN,
    members: Groups = _GROUPS,
    usual: Mapping[str, float] = MappingProxyType({}),
) -> Paths:
    """The table of the Blocks given; the truth's paths have no prefix, those of others begin with their name.

    usual: path → what the number is where the default of the Block is not meant.
    """
    blocks = tuple(blocks)
    paths = dict(run)

    def add(path: str, parameter: Parameter) -> None:
        if path not in paths:
            paths[path] = replace(parameter, default=usual[path]) if path in usual else parameter

    for block in blocks:
        for path, parameter in zip(block_paths(block), block.parameters.values(), strict=True):
            add(path, parameter)
            if parameter.shared:
                add(parameter.shared, parameter)
    return Paths(blocks, paths, run, members)


def block_paths(block: Block) -> list[str]:
    """The path of each parameter of `block`, in order."""
    return [name if block.name == "truth" else f"{block.name}.{name}" for name in block.p]
