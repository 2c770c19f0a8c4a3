"""The search: NSGA-II of Optuna, a genetic algorithm with constraints and any number of objectives, in rounds."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import optuna
from optuna.distributions import BaseDistribution, FloatDistribution
from optuna.exceptions import ExperimentalWarning
from optuna.samplers import NSGAIISampler
from optuna.samplers.nsgaii import BLXAlphaCrossover
from optuna.storages import JournalStorage
from optuna.trial import FrozenTrial, TrialState

from ...model.arrays import Array
from ...observers.conditions import Truths
from ..files.progress import CountedProgress
from ..sweep.axes import Range
from .journal import Journal

# trials of a round, which is a generation
ROUND = 50
# the first generation is the best of so many draws about the scenario's own numbers, by what they break
_DRAWN = 4_000
# their standard deviation, as a part of a range
_WIDTH = 1 / 6
# what Optuna knows of a trial beside its values
_BROKEN = "broken"


@dataclass(frozen=True)
class Judge:
    """How trials are judged. own: the numbers that the search begins at.

    broken: (trials × numbers) → (trials) what each breaks without being run, 0 if it is allowed.
    judged: the same, after a run, and (trials × objectives) the factors; infinite where something is broken.
    """

    own: Array
    objectives: int
    broken: Callable[[Array], Array]
    judged: Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Trials:
    """(trials × …) what was tried: numbers in the order of the ranges, what they break, a factor for each objective."""

    numbers: Array
    broken: Array
    factors: Array


def search(
    ranges: Mapping[str, Range], trials: int, judge: Judge, journal: Journal, progress: CountedProgress
) -> Trials:
    """So many trials, in whole rounds. What the journal has is not tried again; each round follows from those before.

    So a search that was killed and goes on ends as one that was not.
    """
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    study = optuna.create_study(
        storage=JournalStorage(journal),
        study_name="tune",
        load_if_exists=True,
        directions=["minimize"] * judge.objectives,
    )
    distributions: dict[str, BaseDistribution] = {
        path: FloatDistribution(span.low, span.high, log=span.logarithmic) for path, span in ranges.items()
    }
    if not study.trials:
        for numbers in _first(ranges, judge):
            study.enqueue_trial(dict(zip(ranges, numbers.tolist(), strict=True)))
    rounds = -(-trials // ROUND)
    for done in range(len(_made(study)) // ROUND, rounds):
        progress(done * ROUND, rounds * ROUND)
        # the dice of a round are its own
        study.sampler = _sampler(done)
        asked = [study.ask(distributions) for _ in range(ROUND)]
        broken, factors = judge.judged(np.array([[trial.params[path] for path in ranges] for trial in asked]))
        for trial, breaks, values in zip(asked, broken.tolist(), factors.tolist(), strict=True):
            trial.set_constraint(_BROKEN, breaks)
            study.tell(trial, values)
        journal.keep()
    progress(rounds * ROUND, rounds * ROUND)
    made = _made(study)[: rounds * ROUND]
    return Trials(
        np.array([[trial.params[path] for path in ranges] for trial in made]),
        np.array([trial.constraints[_BROKEN] for trial in made]),
        np.array([trial.values for trial in made]),
    )


def front(trials: Trials) -> Truths:
    """(trials) whether each is allowed, and no other that is allowed is as good in all and better in something."""
    factors = np.where(trials.broken[:, None] > 0, np.inf, trials.factors)
    no_worse, better = (factors[None] <= factors[:, None]).all(axis=2), (factors[None] < factors[:, None]).any(axis=2)
    at: Truths = (trials.broken == 0) & ~np.any(no_worse & better, axis=1)
    return at


def _made(study: optuna.Study) -> list[FrozenTrial]:
    return study.get_trials(deepcopy=False, states=[TrialState.COMPLETE])


def _sampler(seed: int) -> NSGAIISampler:
    with warnings.catch_warnings():
        # of those that Optuna has, it came closest to the best known gains from all starts
        warnings.simplefilter("ignore", ExperimentalWarning)
        crossover = BLXAlphaCrossover()
    return NSGAIISampler(population_size=ROUND, crossover=crossover, seed=seed)


def _first(ranges: Mapping[str, Range], judge: Judge) -> Array:
    """(trials × numbers) the first generation: the scenario's own numbers, and others about them."""
    low, high = (np.array([getattr(span, end) for span in ranges.values()]) for end in ("low", "high"))
    logarithmic = np.array([span.logarithmic for span in ranges.values()])

    def scale(values: Array) -> Array:
        return np.where(logarithmic, np.log(np.where(logarithmic, values, 1.0)), values)

    width = _WIDTH * (scale(high) - scale(low))
    drawn = scale(judge.own) + width * np.random.default_rng(ROUND).standard_normal((_DRAWN, len(ranges)))
    drawn = np.where(logarithmic, np.exp(np.where(logarithmic, drawn, 0.0)), drawn)
    numbers = np.clip(np.vstack([judge.own, drawn]), low, high)
    order = np.argsort(judge.broken(numbers)[1:], kind="stable")
    return np.vstack([numbers[:1], numbers[1:][order[: ROUND - 1]]])
