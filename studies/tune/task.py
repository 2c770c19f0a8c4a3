"""What is to be tuned, and on which runs: everything that can be wrong before the search starts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...codegen.batch import Trace, compile_loop
from ...model.arrays import Array
from ...model.block import Block
from ..files.errors import ScenarioError
from ..files.numbers import whole
from ..files.quote import shown, table
from ..scenarios.layers import Value, written
from ..scenarios.prepare import Prepared, prepare
from ..simulate.run import recorded
from ..sweep.axes import Axes, Range, check_range
from ..sweep.computing import Compute
from ..sweep.plan import Plan, Seeds, plan
from .candidates import Candidates
from .equations import equations
from .ranges import usual_ranges
from .trajectories import Trajectories, trajectories

# trajectories beside the scenario's own: those that gains are tuned on, and those that they are tested on
_TRAINING, _TESTS = 2, 4
# what these are drawn with
_DICE_OF_TRAINING, _DICE_OF_TESTS = 0, 1
# noise of a test is drawn so often
_TEST_SEEDS = 10
# the front compares each trial with each other one
_MOST_TRIALS, _MOST_SEEDS = 20_000, 1_000

_PERIOD = "noise.period"

# a quantity, or several with commas between or as a list, whose errors are one objective
Objective = str | Sequence[str]


@dataclass(frozen=True)
class Task:
    """scenario: path → value as written, with its base. objectives: each the quantities whose errors are one."""

    scenario: Mapping[str, object]
    observer: str
    ranges: Mapping[str, Range]
    objectives: tuple[tuple[str, ...], ...]
    trials: int
    candidates: Candidates
    training: Trajectories
    tests: Trajectories

    @property
    def plan(self) -> Plan:
        """Of the scenario and the observer alone; its seeds are those of the training runs."""
        return self.candidates.plan

    @property
    def own(self) -> Array:
        """The scenario's own numbers, in the order of the ranges."""
        prepared = self.plan.prepared
        return np.array([prepared.value(prepared.paths.expand(path)[0]) for path in self.ranges])

    @property
    def test_seeds(self) -> Seeds:
        """Seeds that no training run has."""
        first = int(self.plan.seeds.max()) + 1
        return np.arange(first, first + (_TEST_SEEDS if _is_noisy(self.plan.prepared) else 1), dtype=np.uint64)


def task(
    source: str | Path,
    observer: str | Block,
    quantities: Sequence[Objective] | None,
    over: Mapping[str, object],
    trials: int,
    seeds: int,
    changes: Mapping[str, Value],
    corrected: bool,
    compute: Compute,
) -> Task:
    """ScenarioError says what is wrong."""
    if not isinstance(observer, str | Block):
        raise ScenarioError(f"a search is of one observer, not {shown(observer)}")
    prepared = prepare(source, observer, changes, corrected=corrected)
    (name,) = prepared.chosen
    ranges = dict(_checked(table("over", over))) or usual_ranges(prepared, prepared.chosen[name], name)
    following = tuple(equations(prepared))
    solved = {one.path for one in following}
    if fixed := [path for path in ranges if solved & set(prepared.paths.expand(path))]:
        raise ScenarioError(f"{fixed[0]} follows from other numbers by a gain condition; tune those")
    ends = {path: [span.low, span.high] for path, span in ranges.items()}
    count = whole("seeds", seeds, 1, _MOST_SEEDS) if _is_noisy(prepared) else 1
    # as if the ends of all ranges were swept: each must be a number that changes something
    checked = plan(source, ends, count, observer, changes, "zip", corrected=corrected)
    alone = replace(checked, axes=Axes("zip", (), ()))
    compiled = compile_loop(alone.loop)
    training = trajectories(prepared, _TRAINING, _DICE_OF_TRAINING)
    truths = [
        _truth(recorded(prepare(source, observer, {**changes, **training.changes(i)}, corrected=corrected), compiled))
        for i in range(len(training.values))
    ]
    return Task(
        written(source, changes),
        name,
        ranges,
        _objectives(quantities, prepared.quantities),
        whole("trials", trials, 1, _MOST_TRIALS),
        Candidates(alone, compiled, tuple(ranges), following, truths, compute),
        training,
        trajectories(prepared, _TESTS, _DICE_OF_TESTS),
    )


def _is_noisy(prepared: Prepared) -> bool:
    """Whether runs of different seeds are different."""
    noise = (path for path in prepared.paths.parameters if path.startswith("noise.") and path != _PERIOD)
    return prepared.value(_PERIOD) > 0 and any(map(prepared.value, noise))


def _checked(over: Mapping[str, object]) -> Iterator[tuple[str, Range]]:
    for path, span in over.items():
        if not isinstance(span, Range) or span.count:
            raise ScenarioError(f"{path}: a search needs a range without a number of values, such as log:0.02:0.5")
        check_range(path, span)
        yield path, span


def _objectives(quantities: Sequence[Objective] | None, known: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    if quantities is None:
        return (tuple(known),)
    if isinstance(quantities, str) or not isinstance(quantities, Sequence):
        raise ScenarioError(f"quantities must be a list of objectives, not {shown(quantities)}")
    groups = [one.split(",") if isinstance(one, str) else _names(one) for one in quantities]
    named = [quantity for group in groups for quantity in group]
    for quantity in named:
        if quantity not in known:
            raise ScenarioError(f"unknown quantity {shown(quantity)}; there are {', '.join(known)}")
    if not named or not all(groups):
        raise ScenarioError("a search needs at least one quantity")
    if len(set(named)) < len(named):
        raise ScenarioError("a quantity is named twice")
    return tuple(map(tuple, groups))


def _names(objective: object) -> list[str]:
    if not isinstance(objective, Sequence):
        raise ScenarioError(f"an objective is the name of a quantity, or several, not {shown(objective)}")
    return list(objective)


def _truth(traces: Mapping[str, Trace]) -> Trace:
    truth = traces["truth"]
    if truth.failure:
        raise ScenarioError(
            f"the plant fails at τ = {truth.failure.time:g} on a trajectory drawn about the scenario's own"
        )
    return truth
