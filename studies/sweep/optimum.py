"""Where the errors of a sweep are smallest: medians over the seeds, and the values that belong to them."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np
import xarray as xr

from ...model.arrays import Array
from ...model.symbols import QUANTITIES
from ...observers import OBSERVERS
from .axes import Axes


def axes_of(dataset: xr.Dataset) -> Axes:
    """The axes of a sweep's result."""
    paths = json.loads(dataset.attrs["axes"])
    return Axes(dataset.attrs["kind"], tuple(paths), tuple(dataset[path].values for path in paths))


def shown_of(dataset: xr.Dataset, usual: Sequence[str]) -> list[str]:
    """The quantities to show: the usual ones of all, or those that were asked for."""
    there: list[str] = dataset.quantity.values.tolist()
    return list(usual) if len(there) == len(QUANTITIES) else there


def failed(dataset: xr.Dataset) -> xr.DataArray:
    """(…, seed, observer) whether the observer or the plant failed."""
    lost: xr.DataArray = dataset.failed_at.notnull() | dataset.plant_failed_at.notnull()
    return lost


def errors(dataset: xr.Dataset) -> xr.DataArray:
    """RMSE (…, seed, observer, quantity); a failed run is infinitely wrong, else those that survive would be chosen."""
    counted: xr.DataArray = dataset.rmse.where(~failed(dataset), np.inf)
    return counted


def medians(dataset: xr.Dataset) -> xr.DataArray:
    """Median RMSE over the seeds (…, observer, quantity); NaN where half of the runs failed."""
    median = errors(dataset).median("seed")
    return median.where(np.isfinite(median))


def free(dataset: xr.Dataset, observer: str) -> list[str]:
    """The swept parameters that an optimum is sought over: the observer's own; if it has none, those of no observer."""
    owners = {path: path.partition(".")[0] for path in axes_of(dataset).paths}
    own = [path for path, owner in owners.items() if owner == observer]
    others = {*OBSERVERS, *dataset.observer.values.tolist()}
    return own or [path for path, owner in owners.items() if owner not in others]


def best(dataset: xr.Dataset, median: xr.DataArray, observer: str) -> xr.DataArray | None:
    """The smallest of `median` (…) with its coordinates, or None if it has no numbers.

    What is not the observer's to choose is held at the scenario's value, if this is within the range.
    """
    if axes_of(dataset).kind == "grid":
        held = {path: own_place(dataset, path) for path in median.dims if path not in free(dataset, observer)}
        median = median.isel({path: place for path, place in held.items() if place is not None})
    if not median.notnull().any():
        return None
    return median.isel({dim: int(place) for dim, place in median.argmin(...).items()}) if median.dims else median


def at_scenario(dataset: xr.Dataset, median: xr.DataArray) -> float:
    """The number of `median` (…) nearest to the scenario's own values; NaN if these are not in the ranges of a grid."""
    if axes_of(dataset).kind != "grid":
        return np.nan
    places = {path: own_place(dataset, path) for path in median.dims}
    if any(place is None for place in places.values()):
        return np.nan
    return float(median.isel(places))


def own_value(dataset: xr.Dataset, path: str) -> float | None:
    """The scenario's value of a swept parameter, if there is one and it is in the range."""
    values = dataset[path].values
    own = float(dataset[path].attrs.get("scenario_value", np.nan))
    return own if values.min() <= own <= values.max() else None


def own_place(dataset: xr.Dataset, path: object) -> int | None:
    """The place of the swept value nearest to the scenario's, if this is in the range."""
    values, own = dataset[str(path)].values, own_value(dataset, str(path))
    if own is None:
        return None
    scale = np.log if logarithmic(values) else np.asarray
    return int(np.abs(scale(values) - scale(own)).argmin())


def logarithmic(values: Array) -> bool:
    """Whether values reach far and are spread more evenly in the logarithm."""
    ordered = np.unique(values)
    if len(ordered) < _FEWEST or ordered[-1] < _FAR * ordered[0] or ordered[0] <= 0:
        return False
    linear, ratios = np.diff(ordered), np.diff(np.log(ordered))
    return bool(np.std(ratios) / np.mean(ratios) < np.std(linear) / np.mean(linear))


# two values lie evenly on any scale; a short axis of logarithms would have no number on it
_FEWEST, _FAR = 3, 5.0
