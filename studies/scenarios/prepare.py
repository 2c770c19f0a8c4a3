"""Everything of a run that can be wrong before it starts."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ...codegen.loop import Loop
from ...codegen.memory import Grid
from ...model.symbols import hat
from ...model.system import System
from ...observers import PAPER, Observer
from ...observers.score import MEASURES
from ..files.errors import ScenarioError
from ..files.numbers import switch
from ..files.quote import shown
from .grid import time_grid
from .layers import Value, layers
from .observers import Observers, observers_named, own_among
from .paths import Paths
from .rules import Rule, rules
from .scenario import Scenario, choices, scenario
from .world import FEEDBACK, named_mechanism, world_of

BASELINE = "baseline"

# a name of a file has at most 255 bytes; what is longer gets so many digits of a hash
_LONGEST_LABEL, _DIGITS = 120, 8


@dataclass(frozen=True)
class Prepared:
    """A checked scenario with the Blocks that run it."""

    scenario: Scenario
    loop: Loop
    paths: Paths
    grid: Grid
    chosen: Mapping[str, Observer]
    corrected: bool  # the layers of sliding mode observers
    quantities: tuple[str, ...]
    measures: tuple[str, ...]

    @property
    def system(self) -> System:
        """The joints and muscles."""
        return self.scenario.world.system

    @property
    def observers(self) -> tuple[str, ...]:
        """The names of the observers that are asked for."""
        return tuple(self.chosen)

    @property
    def label(self) -> str:
        """The scenario and what is changed beside it, such as `paper-noisy,high_gain.eps_h=0.2`: files are named so."""
        changes = [
            f"{path}={_spelled(value)}" for path, value in self.scenario.changes.items() if path != "description"
        ]
        observers = [] if self.observers == PAPER else self.observers
        words = [*changes, *observers, *["corrected"] * self.corrected]
        label = ",".join([self.scenario.name, *words])
        if len(label) <= _LONGEST_LABEL:
            return label
        digest = hashlib.sha256(label.encode()).hexdigest()[:_DIGITS]
        return f"{self.scenario.name},{len(words)} changes,{digest}"

    def value(self, path: str) -> float:
        """The number at `path`."""
        return self.paths.value(path, self.scenario.given)

    @property
    def rules(self) -> list[Rule]:
        """What must hold between its numbers, those of observers that are not asked for too."""
        return [*rules(self.loop.truth, self.paths.blocks, self.system.curves)]

    def further_states(self) -> Iterator[tuple[str, str, str]]:
        """Variable of the result, observer and state, for each state that is no estimate; with a dot it is inner."""
        for block in self.loop.observers:
            if block.name in self.observers:
                further = (state for state in block.x if state not in block.y and "." not in state)
                yield from ((f"{block.name}_{state}", block.name, state) for state in further)


def prepare(
    source: str | Path,
    observers: Observers,
    changes: Mapping[str, Value],
    quantities: Sequence[str] | None = None,
    measures: Sequence[str] = MEASURES,
    corrected: bool = False,
) -> Prepared:
    """Everything of a run that can be wrong before it starts. ScenarioError says what is.

    quantities, measures: what is scored, and how, all by default; corrected: the layers of sliding mode observers.
    """
    name, stacked = layers(source, changes)
    chosen, mechanism = observers_named(observers), named_mechanism(stacked)
    own = own_among(chosen)
    choice = choices(stacked, mechanism, own)
    world = world_of(choice, mechanism)
    # in the order of the tables, whatever the order asked for; the RMSE is always among the measures
    known = world.system.quantities
    scored = _scored("quantity", known if quantities is None else quantities, known)
    taken = _scored("measure", ["rmse", *measures], MEASURES)
    paths = world.paths(tuple(own.values()), switch("corrected", corrected))
    return assemble(scenario(name, stacked, paths, choice, mechanism), chosen, scored, taken, corrected)


def _scored(what: str, names: Sequence[str], known: Sequence[str]) -> tuple[str, ...]:
    """Those of `known` that are named. ScenarioError if another one is, or none."""
    for name in names:
        if name not in known:
            raise ScenarioError(f"unknown {what} {shown(name)}; there are {', '.join(known)}")
    if not names:
        raise ScenarioError(f"a sweep needs at least one {what}")
    return tuple(name for name in known if name in names)


def _spelled(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def assemble(
    checked: Scenario,
    chosen: Mapping[str, Observer],
    quantities: tuple[str, ...],
    measures: tuple[str, ...],
    corrected: bool = False,
) -> Prepared:
    """The Blocks that run a scenario; ScenarioError for numbers that do not fit together."""
    world = checked.world
    paths = world.paths(tuple(own_among(chosen).values()), corrected)
    loop = world.loop(chosen, corrected, quantities, measures)
    grid = time_grid(lambda path: paths.value(path, checked.given), world.pulses)
    prepared = Prepared(checked, loop, paths, grid, chosen, corrected, quantities, measures)
    _check_numbers(prepared)
    _check_samples(prepared)
    _check_variables(prepared)
    return prepared


def _check_numbers(prepared: Prepared) -> None:
    for rule in prepared.rules:
        if objection := rule.objection(prepared.paths, prepared.scenario.given):
            raise ScenarioError(objection)


def _check_samples(prepared: Prepared) -> None:
    sampled = [block.name for block in prepared.loop.observers if block.name in prepared.observers and block.next]
    if prepared.loop.truth.next:
        sampled.append(f"what {FEEDBACK} names")
    if sampled and not prepared.grid.hold:
        raise ScenarioError(f"{sampled[0]} moves at samples only, and noise.period = 0 takes none; it must be above 0")


def _check_variables(prepared: Prepared) -> None:
    taken = {hat(group) for group in ("x", "u", "a", "Delta")}
    for variable, observer, state in prepared.further_states():
        if variable in taken:
            raise ScenarioError(
                f"{observer}: its state {state} would be called {variable} in the result, which is taken; rename it"
            )
        taken.add(variable)
