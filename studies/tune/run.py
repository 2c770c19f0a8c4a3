"""Gains of one observer by search: tuned on some runs, told how good they are on others."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from ...model.arrays import Array
from ...model.block import Block
from ..files.errors import ScenarioError
from ..files.progress import CountedProgress, unseen
from ..scenarios.layers import Value
from ..sweep.axes import Range
from ..sweep.run import engine
from .dataset import of_tests, of_trials
from .journal import Journal
from .search import Judge, Trials, front, search
from .task import Objective, Task, task


@dataclass(frozen=True)
class Tuned:
    """What a search has found.

    numbers: path → value of the best, for `changes` of `simulate` and `sweep`; of several objectives the best has the
    smallest product of factors. scenario: path → value as written of the scenario that it is for, with its `base`.
    corrected: whether the gains are for corrected layers.
    trials: number (trial, path), broken (trial), front (trial), factor (trial, objective): the error over that of the
    scenario's own gains. tests: rmse (gains, trajectory, seed, quantity), of the scenario's own gains and the best, in
    runs that the search has not seen; trajectory 0 is the scenario's own.
    """

    numbers: Mapping[str, float]
    scenario: Mapping[str, object]
    corrected: bool
    trials: xr.Dataset
    tests: xr.Dataset


def tune(
    source: str | Path = "paper-noisy",
    observer: str | Block = "high_gain",
    quantities: Sequence[Objective] | None = None,
    over: Mapping[str, Range] | None = None,
    trials: int = 2000,
    seeds: int = 4,
    changes: Mapping[str, Value] | None = None,
    out: str | Path | None = None,
    workers: int | None = None,
    progress: CountedProgress | None = None,
    corrected: bool = False,
) -> Tuned:
    """Gains of an observer for which its errors are smallest, within its gain conditions, by a genetic algorithm.

    source, observer, changes, corrected: as for `simulate`.
    quantities: each makes an objective of its error; several in one text, with commas, one of their geometric mean. All
        in one by default.
    over: path → Range of what is tuned; by default the observer's own gains, to a 30th and to the 30-fold.
    trials: in rounds of 50. seeds: noise of the training runs is drawn so often, on the scenario's own trajectory and
        on two drawn about it.
    out: file of the search, Optuna's journal; the same call goes on where it was.
    workers, progress: as for `sweep`; progress counts trials.
    Needs the extra `tune`. ScenarioError for what cannot be tuned, and if no trial fulfils the gain conditions;
    ResultError for `out`.

    >>> found = hillobs.tune("paper-noisy", "high_gain", trials=50, seeds=1)
    >>> run = hillobs.simulate("paper-noisy", "high_gain", changes=found.numbers)
    """
    with engine(workers, None) as (compute, _):
        asked = task(source, observer, quantities, over or {}, trials, seeds, changes or {}, corrected, compute)
        return tuned(asked, None if out is None else Path(out), progress or unseen)


def tuned(task: Task, journal: Path | None, progress: CountedProgress) -> Tuned:
    """Search as `task` says, keeping the trials in the file `journal` if one is given."""
    made = search(task.ranges, task.trials, _judge(task), Journal(journal, _identity(task)), progress)
    on_front = front(made)
    if not on_front.any():
        raise ScenarioError(_hopeless(task, made))
    # of several objectives the smallest product of factors
    best = int(np.argmin(np.where(on_front, np.log(made.factors).sum(axis=1), np.inf)))
    axes = task.candidates.axes(made.numbers[[best]])
    numbers = {path: float(values[0]) for path, values in zip(axes.paths, axes.values, strict=True)}
    both = np.array([task.own, made.numbers[best]])
    rmse = task.candidates.errors(both, task.tests, task.test_seeds)
    return Tuned(
        numbers,
        task.scenario,
        task.plan.prepared.corrected,
        of_trials(task, made, on_front, best),
        of_tests(task, rmse),
    )


def _judge(task: Task) -> Judge:
    candidates, seeds, quantities = task.candidates, task.plan.seeds, task.plan.quantities
    places = [[quantities.index(quantity) for quantity in objective] for objective in task.objectives]
    own = candidates.errors(task.own[None], task.training, seeds)[0]
    if np.isnan(own).any():
        raise ScenarioError(
            f"{task.observer} fails with the scenario's own gains; set some to begin at, with which it does not"
        )

    def judged(numbers: Array) -> tuple[Array, Array]:
        broken = candidates.broken(numbers)
        factors = np.full((len(numbers), len(places)), np.inf)
        if (allowed := broken == 0).any():
            ratios = np.log(candidates.errors(numbers[allowed], task.training, seeds) / own)
            # a run that fails breaks something too
            broken[allowed] = np.isnan(ratios).any(axis=3).mean(axis=(1, 2))
            # geometric means over trajectories, seeds and quantities
            means = np.stack([np.exp(ratios[..., place].mean(axis=(1, 2, 3))) for place in places], axis=1)
            factors[allowed] = np.where(broken[allowed, None] > 0, np.inf, means)
        return broken, factors

    return Judge(task.own, len(places), candidates.broken, judged)


def _identity(task: Task) -> str:
    """A hash of all that determines the trials, but for how many they are."""
    ranges = {path: [span.low, span.high, span.logarithmic] for path, span in task.ranges.items()}
    about = [task.plan.description(task.candidates.compiled.path.stem), ranges, task.objectives]
    return hashlib.sha256(json.dumps([*about, task.training.values.tolist()]).encode()).hexdigest()


def _hopeless(task: Task, made: Trials) -> str:
    """Why nothing was found."""
    violated = [
        (int(at.sum()), name)
        for of_truth in task.candidates.violated(made.numbers)
        for conditions in of_truth.values()
        for name, at in conditions.items()
    ]
    words = f"none of {len(made.broken):,} trials fulfils all gain conditions without a failure"
    return f"{words}; most often broken: {max(violated)[1]}" if violated else words
