"""What a result must have to be a run."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr

from ...model.curves import Curves, by_muscle
from ...model.symbols import MEASURED, STATES
from ..files.datasets.schema import FLOATS, TEXTS, WHOLES, Schema, rising
from ..files.errors import ResultError, ScenarioError
from ..files.numbers import within
from ..scenarios.scenario import CHOICES, curves_of

_TIME, _BY_OBSERVER = ("time",), ("observer", "time")

RUN = Schema(
    variables={
        "time": (_TIME, FLOATS),
        "muscle": (("muscle",), WHOLES),
        "observer": (("observer",), TEXTS),
        "x": ((*_TIME, "state"), FLOATS),
        "u": ((*_TIME, "muscle"), FLOATS),
        "a": ((*_TIME, "muscle"), FLOATS),
        "Delta": (_TIME, FLOATS),
        "y": ((*_TIME, "sensor"), FLOATS),
        "taut": ((*_TIME, "muscle"), FLOATS),
        "x_hat": ((*_BY_OBSERVER, "state"), FLOATS),
        "u_hat": ((*_BY_OBSERVER, "muscle"), FLOATS),
        "a_hat": ((*_BY_OBSERVER, "muscle"), FLOATS),
        "Delta_hat": (_BY_OBSERVER, FLOATS),
    },
    optional={"r": (_TIME, FLOATS)},
    labels={"state": tuple(STATES), "muscle": (1, 2), "sensor": tuple(MEASURED), "observer": None},
    attributes={"scenario": str, "run": str, "choices": dict[str, str], "parameters": dict[str, float]},
)


def check_run(dataset: xr.Dataset) -> None:
    """ResultError says why a Dataset is no run."""
    attributes = RUN.check(dataset)
    rising(dataset, "time")
    check_curves(chosen_curves(attributes["choices"]), attributes["parameters"])


def chosen_curves(choices: Mapping[str, str]) -> Curves:
    """The curve sets that the choices of a result name. ResultError if there are none of that name."""
    for path, valid in CHOICES.items():
        if choices.get(path) not in valid:
            raise ResultError(f"its {path} must be one of {', '.join(valid)}")
    return curves_of(choices)


def check_curves(curves: Curves, parameters: Mapping[str, float]) -> None:
    """ResultError if the numbers make no tendon."""
    for muscle, curve_set in by_muscle(curves).items():
        values = {key: parameters.get(f"{muscle}.{key}") for key in curve_set.tendon}
        try:
            numbers = {key: within(f"{muscle}.{key}", value, curve_set.tendon[key]) for key, value in values.items()}
        except ScenarioError as error:
            raise ResultError(f"its {error}") from error
        if objection := curve_set.objection(numbers):
            raise ResultError(f"its {muscle}: {objection}")
