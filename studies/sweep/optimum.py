"""Where the median errors of a sweep are smallest, what speaks against calling it the best, and how they change."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from ...model.arrays import Array
from ...model.symbols import QUANTITIES, kind_of
from .axes import Axes


def axes_of(dataset: xr.Dataset) -> Axes:
    """The axes of a sweep's result."""
    paths = json.loads(dataset.attrs["axes"])
    return Axes(dataset.attrs["kind"], tuple(paths), tuple(dataset[path].values for path in paths))


# of the seeds, the middle two thirds
SPREAD = (1 / 6, 5 / 6)


def shown_of(dataset: xr.Dataset, usual: Sequence[str]) -> list[str]:
    """The quantities to show: the usual ones of all, or those that were asked for."""
    there: list[str] = dataset.quantity.values.tolist()
    if len(there) == len(QUANTITIES) and there[0] in QUANTITIES:
        return list(usual)
    # of a mechanism those of the same kinds
    kinds = {kind_of(name) for name in usual}
    whole = there[0] not in QUANTITIES and {*map(kind_of, there)} >= {*map(kind_of, QUANTITIES)}
    return [name for name in there if kind_of(name) in kinds] if whole else there


def failed(dataset: xr.Dataset) -> xr.DataArray:
    """(…, seed, observer) whether the observer or the plant failed."""
    lost: xr.DataArray = dataset.failed_at.notnull() | dataset.plant_failed_at.notnull()
    return lost


def errors(dataset: xr.Dataset) -> xr.DataArray:
    """RMSE (…, seed, observer, quantity); a failed run is infinitely wrong, else those that survive would be chosen."""
    rmse: xr.DataArray = dataset.rmse.where(~failed(dataset), np.inf)
    return rmse


def medians(dataset: xr.Dataset) -> xr.DataArray:
    """Median RMSE over the seeds (…, observer, quantity); NaN where half of the runs failed."""
    median = errors(dataset).median("seed")
    return median.where(np.isfinite(median))


@dataclass(frozen=True)
class Optimum:
    """The smallest median error of an observer, where it is, and what speaks against calling it the best."""

    error: float
    values: Mapping[str, float]  # of each swept parameter
    edges: tuple[str, ...]  # parameters of the observer at the end of what was swept: the optimum may lie beyond
    violated: tuple[int, ...]  # places along `condition` of the gain conditions that do not hold there

    @property
    def inside(self) -> bool:
        """Whether nothing speaks against it."""
        return not self.edges and not self.violated


def varied(dataset: xr.Dataset) -> list[str]:
    """The swept parameters with more than one value."""
    return axes_of(dataset).varied


def depends(dataset: xr.Dataset, observer: str) -> bool:
    """Whether what was swept changes any error of an observer."""
    each = dataset.rmse.sel(observer=observer)
    first = each.isel({dim: 0 for dim in each.dims if dim not in ("seed", "quantity")})
    # a run that failed has no number, which equals nothing
    return not bool((each == first).all())


def parameters_of(dataset: xr.Dataset, observer: str) -> list[str]:
    """The parameters that vary and are the observer's to choose: its own, not those of the plant or the noise."""
    return [path for path in varied(dataset) if _owner(path) == observer]


def held(dataset: xr.Dataset) -> dict[str, int | None]:
    """What varies and is no observer's to choose, and the place where optima hold it: nearest to the scenario's value.

    None where it cannot be held: the scenario has no single value, or the points are no grid.
    """
    observers, grid = dataset.observer.values.tolist(), axes_of(dataset).kind == "grid"
    others = [path for path in varied(dataset) if _owner(path) not in observers]
    return {path: nearest(dataset, path) if grid else None for path in others}


def violated(dataset: xr.Dataset, observer: str) -> xr.DataArray:
    """(condition, …) where gain conditions of an observer do not hold, without those that hold nowhere.

    What holds nowhere tells no point of the sweep from another; the sentences of the result name it.
    """
    if "condition_violated" not in dataset:
        points: xr.DataArray = dataset.plant_failed_at.isel(seed=0, drop=True)
        return xr.zeros_like(points, dtype=bool).expand_dims(condition=0)
    at = dataset.condition_violated
    some = (at.condition_observer == observer) & ~at.all([dim for dim in at.dims if dim != "condition"])
    placed: xr.DataArray = at.assign_coords(place=("condition", np.arange(at.sizes["condition"])))
    return placed.isel(condition=np.flatnonzero(some.values))


def optimum(dataset: xr.Dataset, median: xr.DataArray, observer: str) -> Optimum | None:
    """The smallest of `median` (…) over the observer's own parameters, with all others `held`.

    None without a parameter of the observer's own, without numbers, and where another one cannot be held.
    """
    places = held(dataset)
    if not parameters_of(dataset, observer) or None in places.values():
        return None
    return smallest(dataset, median.isel(places), observer)


def smallest(dataset: xr.Dataset, median: xr.DataArray, observer: str) -> Optimum | None:
    """The smallest of `median` (…), a part of what was swept; None if there are no numbers, or all are the same."""
    if not median.notnull().any() or (median.size > 1 and bool((median == median.values.flat[0]).all())):
        return None
    places = {dim: int(place) for dim, place in median.argmin(...).items()} if median.dims else {}
    least = median.isel(places)
    others = {*dataset.observer.values.tolist()} - {observer}
    values = {path: float(least[path]) for path in axes_of(dataset).paths if _owner(path) not in others}
    fails = violated(dataset, observer)
    point = {dim: places[dim] for dim in fails.dims if dim == "point"}
    here = fails.isel(point).sel({dim: least[dim] for dim in fails.dims if dim not in ("point", "condition")})
    ends = {path: (dataset[path].values.min(), dataset[path].values.max()) for path in parameters_of(dataset, observer)}
    return Optimum(
        float(least),
        values,
        tuple(path for path, limits in ends.items() if values[path] in limits),
        tuple(here.place.values[here.values].tolist()) if here.size else (),
    )


def at_scenario(dataset: xr.Dataset, median: xr.DataArray) -> float:
    """The number of `median` (…) nearest to the scenario's own values; NaN if these are not in the ranges of a grid."""
    if axes_of(dataset).kind != "grid" or any(own_value(dataset, str(path)) is None for path in median.dims):
        return np.nan
    return float(median.isel({path: nearest(dataset, str(path)) for path in median.dims}))


def own_value(dataset: xr.Dataset, path: str) -> float | None:
    """The scenario's value of a swept parameter, if there is one and it is in the range."""
    values, given = dataset[path].values, _scenario_value(dataset, path)
    return given if values.min() <= given <= values.max() else None


def nearest(dataset: xr.Dataset, path: str) -> int | None:
    """The place of the swept value nearest to the scenario's, or None if the scenario has no single one."""
    values, given = dataset[path].values, _scenario_value(dataset, path)
    if np.isnan(given):
        return None
    scale = np.log if logarithmic(values) and given > 0 else np.asarray
    return int(np.abs(scale(values) - scale(given)).argmin())


def _scenario_value(dataset: xr.Dataset, path: str) -> float:
    """The scenario's value of a swept parameter; NaN if it has several."""
    return float(dataset[path].attrs.get("scenario_value", np.nan))


def _owner(path: str) -> str:
    return path.partition(".")[0]


def logarithmic(values: Array) -> bool:
    """Whether values reach far and are spread more evenly in the logarithm."""
    ordered = np.unique(values)
    if len(ordered) < _FEWEST or ordered[-1] < _FAR * ordered[0] or ordered[0] <= 0:
        return False
    linear, ratios = np.diff(ordered), np.diff(np.log(ordered))
    return bool(np.std(ratios) / np.mean(ratios) < np.std(linear) / np.mean(linear))


# two values lie evenly on any scale; a short axis of logarithms would have no number on it
_FEWEST, _FAR = 3, 5.0
