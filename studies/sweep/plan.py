"""A sweep as a list of runs: which numbers each has, on which grid, and what determines its result."""

from __future__ import annotations

import functools
import hashlib
import itertools
import json
from collections.abc import Iterator, Mapping, Sequence, Sized
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...codegen.loop import Loop
from ...codegen.memory import Grid
from ...model.arrays import Array
from ...model.block import Block
from ...observers import OBSERVERS
from ...observers.score import MEASURES
from ..files.errors import ScenarioError
from ..files.numbers import seeds as listed_seeds
from ..files.numbers import whole
from ..files.quote import table
from ..scenarios.grid import time_grid
from ..scenarios.layers import Value
from ..scenarios.observers import Observers
from ..scenarios.paths import block_paths
from ..scenarios.prepare import BASELINE, Prepared, assemble, prepare
from ..scenarios.scenario import checked_number
from .axes import Axes, Values, axes, combinations
from .row import LAYOUT, row_of

# runs of a part: about two seconds of one core
PART = 512
# a larger sweep must be confirmed
MANY_RUNS = 100_000_000
# steps of all runs that pay for a library of their own: it takes 3 s to compile, and is faster by 20 %, or by 4 % where
# all runs share the truth (docs/performance.md)
PAYS, PAYS_WITH_ONE_TRUTH = 5e8, 5e9
# runs that are computed again at half the step: they fill the widest lanes, and take 0.2 s for the paper's runs
_SAMPLE = 16
# with more of them, not even one score per run fits into a file
_MOST_SEEDS = 100_000_000
# combinations of numbers that limit each other are checked one by one, up to this many
_MOST_CHECKS = 200_000

Seeds = NDArray[np.uint64]


@dataclass(frozen=True)
class Plan:
    """A checked sweep; run r is the point r // len(seeds) with the seed r % len(seeds)."""

    prepared: Prepared
    axes: Axes
    seeds: Seeds
    observers: tuple[str, ...]
    part: int  # runs that are computed, kept and counted together

    @property
    def quantities(self) -> tuple[str, ...]:
        """What is scored."""
        return self.prepared.quantities

    @property
    def measures(self) -> tuple[str, ...]:
        """How it is scored."""
        return self.prepared.measures

    @property
    def runs(self) -> int:
        """How many runs there are."""
        return self.axes.size * len(self.seeds)

    @property
    def parts(self) -> int:
        """How many parts they come in."""
        return -(-self.runs // self.part)

    @property
    def row(self) -> np.dtype[np.void]:
        """The layout of the numbers of one run."""
        return row_of(self.observers, self.quantities, self.measures)

    @functools.cached_property
    def loop(self) -> Loop:
        """What computes the runs; in a long sweep the numbers that no axis sets are written into its code."""
        loop, prepared = self.prepared.loop, self.prepared
        swept = {block.name: {place for _, places in self.reach(block) for place in places} for block in loop.blocks}
        pays = PAYS if swept[loop.truth.name] or loop.noisy else PAYS_WITH_ONE_TRUTH
        if self.runs * prepared.grid.steps < pays:
            return loop
        fixed = {}
        for block in loop.blocks:
            numbers = zip(block.p, prepared.paths.values(block, prepared.scenario.given), strict=True)
            fixed[block.name] = {n: value for i, (n, value) in enumerate(numbers) if i not in swept[block.name]}
        return loop.with_numbers(fixed)

    def members(self, part: int) -> NDArray[np.int64]:
        """The runs of a part."""
        return np.arange(part * self.part, min((part + 1) * self.part, self.runs))

    def sample(self) -> NDArray[np.int64]:
        """Runs spread evenly over all, the first and the last among them: those that say how good the step is."""
        count = min(self.runs, _SAMPLE)
        return np.arange(count) * (self.runs - 1) // max(1, count - 1)

    def points(self, runs: NDArray[np.int64]) -> Array:
        """(runs × axes) the values that some runs have on the axes."""
        return self.axes.at(runs // len(self.seeds))

    def seeds_of(self, runs: NDArray[np.int64]) -> Seeds:
        """(runs) the seeds of some runs."""
        return self.seeds[runs % len(self.seeds)]

    def numbers(self, runs: NDArray[np.int64]) -> dict[str, Array]:
        """(runs × numbers) for each Block of the loop."""
        return {block.name: self.numbers_of(block, runs) for block in self.loop.blocks}

    def numbers_of(self, block: Block, runs: NDArray[np.int64]) -> Array:
        """(runs × numbers) in the order of the `p` of `block`."""
        points, fixed = self.points(runs), self.prepared.paths.values(block, self.prepared.scenario.given)
        rows = np.tile(fixed, (len(runs), 1))
        for axis, places in self.reach(block):
            rows[:, places] = points[:, axis : axis + 1]
        return rows

    def on_grids(self, runs: NDArray[np.int64]) -> Iterator[tuple[Grid, NDArray[np.intp]]]:
        """The time grids of some runs, and which of them run on each, counted within `runs`."""
        timed = [i for i, path in enumerate(self.axes.paths) if self.prepared.paths.is_run(path)]
        times, which = np.unique(self.points(runs)[:, timed], axis=0, return_inverse=True)
        for place, values in enumerate(times.tolist()):
            given = dict(zip((self.axes.paths[i] for i in timed), values, strict=True))
            yield self._grid(given), np.flatnonzero(which.ravel() == place)

    def identity(self, library: str) -> str:
        """A hash of all that determines the numbers; `library` names the code."""
        return hashlib.sha256(json.dumps(self.description(library), sort_keys=True).encode()).hexdigest()

    def description(self, library: str) -> dict[str, object]:
        """What determines the numbers, by name."""
        scenario = self.prepared.scenario
        return {
            "scenario": [dict(scenario.choices), dict(scenario.given), *filter(None, [scenario.mechanism])],
            "axes": [self.axes.kind, *zip(self.axes.paths, (v.tolist() for v in self.axes.values), strict=True)],
            "seeds": self.seeds.tolist(),
            "observers": list(self.observers),
            "scored": [list(self.quantities), list(self.measures)],
            "code": [library, self.part, LAYOUT],
        }

    def _grid(self, given: Mapping[str, float]) -> Grid:
        numbers = {**self.prepared.scenario.given, **self.prepared.paths.spread(given)}
        return time_grid(lambda path: self.prepared.paths.value(path, numbers), self.prepared.scenario.world.pulses)

    def reach(self, block: Block) -> list[tuple[int, list[int]]]:
        """For each axis, the places among the numbers of `block` that it sets."""
        paths = self.prepared.paths
        axis_of = paths.spread({path: axis for axis, path in enumerate(self.axes.paths)})
        given = {*self.prepared.scenario.given, *axis_of}
        setters = [axis_of.get(paths.origin(path, given)) for path in block_paths(block)]
        places = [[i for i, setter in enumerate(setters) if setter == axis] for axis in range(len(self.axes.paths))]
        return [(axis, set_there) for axis, set_there in enumerate(places) if set_there]


def plan(
    source: str | Path,
    over: Mapping[str, Values],
    seeds: int | Sequence[int],
    observers: Observers = None,
    changes: Mapping[str, Value] | None = None,
    kind: str = "grid",
    samples: int = 0,
    quantities: Sequence[str] | None = None,
    measures: Sequence[str] = MEASURES,
    corrected: bool = False,
) -> Plan:
    """Everything of a sweep that can be wrong before it starts. ScenarioError says what is."""
    over, changes = table("over", over), table("changes", changes or {})
    if "seed" in changes:
        raise ScenarioError("a sweep has seeds of its own; use seeds, not a change of seed")
    asked, estimators = _observers(observers, over)
    prepared = prepare(source, asked, changes, quantities, measures, corrected)
    swept = axes(over, kind, samples)
    for path, values in zip(swept.paths, swept.values, strict=True):
        if path in ("seed", "record") or not prepared.paths.expand(path):
            raise ScenarioError(f"{path} cannot be swept" + ("; use seeds" if path == "seed" else ""))
        for value in np.unique(values).tolist():
            checked_number(path, value, prepared.paths)
    result = Plan(prepared, swept, _seeds(seeds), estimators or prepared.observers, PART)
    _check_effect(result)
    _check_together(result)
    return result


def _check_effect(plan: Plan) -> None:
    """Each axis must change a number of what runs."""
    loop = plan.prepared.loop
    running = [block for block in loop.blocks if block not in loop.observers or block.name in plan.observers]
    effective = {axis for block in running for axis, _ in plan.reach(block)}
    for axis, path in enumerate(plan.axes.paths):
        if axis not in effective and not plan.prepared.paths.is_run(path):
            raise ScenarioError(f"{path} changes nothing here: nothing that runs and is scored takes it")


def _check_together(plan: Plan) -> None:
    """Each combination of numbers that limit each other must be one that could run."""
    prepared, swept = plan.prepared, plan.axes.paths
    paths, scenario = prepared.paths, prepared.scenario
    # by the last words of their paths: `muscle.k` is that of both
    ruled = {tuple(sorted({path.rpartition(".")[2] for path in rule.paths.values()})) for rule in prepared.rules}
    groups = [[path for path in swept if path.rpartition(".")[2] in words] for words in sorted(ruled)]
    for together in filter(None, [[path for path in swept if paths.is_run(path)], *groups]):
        rows = list(itertools.islice(combinations(plan.axes, together), _MOST_CHECKS + 1))
        if len(rows) > _MOST_CHECKS:
            raise ScenarioError(f"more than {_MOST_CHECKS:,} combinations of {', '.join(together)} are too many")
        for values in rows:
            at = replace(scenario, given={**scenario.given, **paths.spread(values)})
            try:
                assemble(at, prepared.chosen, plan.quantities, plan.measures, prepared.corrected)
            except ScenarioError as error:
                where = ", ".join(f"{path} = {value:g}" for path, value in values.items())
                raise ScenarioError(f"at {where}: {error}") from error


def _observers(given: Observers, over: Mapping[str, Values]) -> tuple[list[str | Block] | None, tuple[str, ...]]:
    """What `prepare` is asked for, and the estimators of the sweep if they are others."""
    if given is None:
        # an axis of one observer says nothing of the others
        owners = dict.fromkeys(path.partition(".")[0] for path in over)
        return [owner for owner in owners if owner in OBSERVERS] or None, ()
    listed = [given] if isinstance(given, str | Block) else list(given)
    names = tuple(dict.fromkeys(o.name if isinstance(o, Block) else o for o in listed))
    asked = [observer for observer in listed if observer != BASELINE]
    return asked or None, names if BASELINE in names else ()


def _seeds(given: int | Sequence[int]) -> Seeds:
    if not isinstance(given, Sized):
        return np.arange(whole("seeds", given, 1, _MOST_SEEDS), dtype=np.uint64)
    listed = listed_seeds("seeds", given, _MOST_SEEDS)
    if len(np.unique(listed)) < len(listed):
        raise ScenarioError("a seed is there twice")
    return listed
