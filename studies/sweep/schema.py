"""What a result must have to be a sweep."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ...model.symbols import QUANTITIES, is_quantity
from ...observers.score import MEASURES
from ..files.datasets.schema import FLAGS, FLOATS, TEXTS, WHOLES, Schema
from ..files.errors import ResultError, ScenarioError
from ..files.numbers import number
from ..files.quote import shown
from .axes import KINDS

# the square of a larger one is no number
_LARGEST_ERROR = 1e150

# what every sweep has, whatever its axes
_ALWAYS = Schema(
    variables={"seed": (("seed",), WHOLES), "observer": (("observer",), TEXTS), "quantity": (("quantity",), TEXTS)},
    labels={"observer": None},
    attributes={
        "scenario": str,
        "identity": str,
        "kind": str,
        "axes": list[str],
        "violated_conditions": dict[str, list[str]],
    },
)


def check_sweep(dataset: xr.Dataset) -> None:
    """ResultError says why a Dataset is no sweep."""
    attributes = _ALWAYS.check(dataset)
    paths, kind = attributes["axes"], attributes["kind"]
    taken = {*_ALWAYS.variables, *MEASURES, "condition", "point"}
    if kind not in KINDS or len(set(paths)) < len(paths) or not taken.isdisjoint(paths):
        raise ResultError("its axes are not those of a sweep")
    points = tuple(paths) if kind == "grid" else ("point",) * bool(paths)
    runs = (*points, "seed")
    scores = ((*runs, "observer", "quantity"), FLOATS)
    conditions = {
        "condition_violated": (("condition", *points), FLAGS),
        "condition_observer": (("condition",), TEXTS),
        "condition": (("condition",), TEXTS),
    }
    Schema(
        variables={
            **{path: ((path,) if kind == "grid" else points, FLOATS) for path in paths},
            "rmse": scores,
            "failed_at": ((*runs, "observer"), FLOATS),
            "plant_failed_at": (runs, FLOATS),
            "failure": ((*runs, "observer"), WHOLES),
            "plant_failure": (runs, WHOLES),
            **(conditions if "condition_violated" in dataset else {}),
        },
        optional=dict.fromkeys(MEASURES, scores),
        attributes={},
    ).check(dataset)
    scored = dataset.quantity.values.tolist()
    if not all(map(is_quantity, scored)) or len(set(scored)) < len(scored) or 0 in dataset.sizes.values():
        raise ResultError(f"its quantity must be some of {', '.join(QUANTITIES)}, or of a mechanism; it needs a run")
    for path in paths:
        _check_axis(dataset, path, kind)
    if not (np.isnan(dataset.rmse.values) | (np.abs(dataset.rmse.values) <= _LARGEST_ERROR)).all():
        raise ResultError("its rmse has numbers that are no errors")
    _check_failures(dataset.failed_at, dataset.failure)
    _check_failures(dataset.plant_failed_at, dataset.plant_failure)


def _check_axis(dataset: xr.Dataset, path: str, kind: str) -> None:
    values, given = dataset[path].values, dataset[path].attrs.get("scenario_value", 0.0)
    try:
        number("scenario_value", given)
    except ScenarioError as error:
        raise ResultError(f"its {shown(path)}: {error}") from error
    if not np.isfinite(values).all() or (kind == "grid" and len(np.unique(values)) < len(values)):
        raise ResultError(f"its values of {shown(path)} are none that can be swept")


def _check_failures(times: xr.DataArray, causes: xr.DataArray) -> None:
    """What failed at a time has a cause, a place in the list of names."""
    names = causes.attrs.get("flag_meanings")
    if not isinstance(names, str) or causes.min() < 0 or causes.max() >= len(names.split()):
        raise ResultError(f"its {causes.name} names no cause")
    if not ((causes.values > 0) == np.isfinite(times.values)).all() or np.isinf(times.values).any():
        raise ResultError(f"its {times.name} and {causes.name} contradict each other")
