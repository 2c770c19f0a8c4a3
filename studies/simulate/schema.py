"""What a result must have to be a run."""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np
import xarray as xr

from ...model.curves import Curves, CurveSet, by_muscle
from ...model.symbols import MEASURED, STATES
from ..files.datasets.schema import FLOATS, TEXTS, WHOLES, Schema, read_json, rising
from ..files.errors import ResultError, ScenarioError
from ..files.numbers import within
from ..laboratory.subject import subject_again
from ..scenarios.world import CHOICES, curves_of

# the variable with what is in a mechanism's file
FILE = "muscle_file"
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
    if FILE in dataset:
        _check_run_of_mechanism(dataset)
        return
    attributes = RUN.check(dataset)
    rising(dataset, "time")
    check_curves(chosen_curves(attributes["choices"]), attributes["parameters"])


def _check_run_of_mechanism(dataset: xr.Dataset) -> None:
    """The same of a mechanism: joints and muscles are those of its file."""
    content = read_json(FILE, str(dataset[FILE].values), dict)
    try:
        subject = subject_again(content)
    except ScenarioError as error:
        raise ResultError(f"its {FILE}: {error}") from error
    system = subject.system
    if system.paper:
        raise ResultError(f"its {FILE} is of a pair")
    led = {"r": ((*_TIME, "place"), FLOATS), "at": ((*_TIME, "place"), FLOATS)} if "place" in dataset else {}
    Schema(
        variables={
            **{name: about for name, about in RUN.variables.items() if name != "muscle"},
            "muscle": (("muscle",), TEXTS),
            "joint": (("joint",), TEXTS),
            "Delta": ((*_TIME, "joint"), FLOATS),
            "Delta_hat": ((*_BY_OBSERVER, "joint"), FLOATS),
            "Phi_S": ((*_TIME, "muscle"), FLOATS),
            **led,
        },
        labels={
            "state": system.states,
            "muscle": system.muscles,
            "joint": system.joints,
            "sensor": system.measured,
            "quantity": system.quantities,
            "observer": None,
        },
        attributes={**RUN.attributes, "scales": {"length": float, "force": float, "rate": float}},
    ).check(dataset)
    places = subject.laws.places(np.zeros(len(system.joints)))
    if led and not set(dataset.place.values.tolist()) <= set(places):
        raise ResultError("its place names something that the mechanism has not")
    rising(dataset, "time")


def curves_by_muscle(dataset: xr.Dataset) -> dict[str, CurveSet]:
    """The curve set of each muscle of a run, by its name."""
    if FILE in dataset:
        return dict(subject_again(json.loads(str(dataset[FILE].values))).system.curves)
    return by_muscle(curves_of(json.loads(dataset.attrs["choices"])))


def chosen_curves(choices: Mapping[str, str]) -> Curves:
    """The curve sets that the choices of a result name. ResultError if there are none of that name."""
    for path, valid in CHOICES.items():
        if choices.get(path, valid[0]) not in valid:
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
