"""Trials and tests of a search with names."""

from __future__ import annotations

import xarray as xr

from ...model.arrays import Array
from ...observers.conditions import Truths
from ..simulate.dataset import about
from .candidates import rounded
from .search import Trials
from .task import Task

# the first and the second of `gains`
GAINS = ("scenario's own", "tuned")


def of_trials(task: Task, made: Trials, front: Truths, best: int) -> xr.Dataset:
    """All trials; `best` is the one whose numbers are taken."""
    coordinates = {"path": list(task.ranges), "objective": [", ".join(names) for names in task.objectives]}
    data = {
        "number": (("trial", "path"), rounded(made.numbers), about("what was tried")),
        "factor": (
            ("trial", "objective"),
            made.factors,
            about("error over that of the scenario's own gains, geometric mean over the training runs"),
        ),
        "broken": ("trial", made.broken, about("gain conditions not fulfilled, or the part of the runs that failed")),
        "front": ("trial", front, about("whether no other allowed trial is as good in all and better in one")),
    }
    return xr.Dataset(data, coordinates, {"best": best, "observer": task.observer})


def of_tests(task: Task, rmse: Array) -> xr.Dataset:
    """(gains × trajectories × seeds × quantities) the errors in runs that the search has not seen."""
    data = {
        "rmse": (("gains", "trajectory", "seed", "quantity"), rmse, about("RMSE, NaN of a run that failed")),
        "signal": (("trajectory", "path"), task.tests.values, about("amplitudes and frequencies of its sines")),
    }
    coordinates = {
        "gains": list(GAINS),
        "seed": task.test_seeds,
        "quantity": list(task.plan.quantities),
        "path": list(task.tests.paths),
    }
    return xr.Dataset(data, coordinates, {"observer": task.observer})
