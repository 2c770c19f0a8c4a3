"""A run as files: NetCDF, its time series and its measures as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from ...model.arrays import Array
from ...model.symbols import MEASURED, STATES, hat
from ..files.errors import ResultError
from ..files.netcdf import save_netcdf
from ..files.writing import write_whole
from .measures import SENTENCES

# an observer's estimates in the order of a CSV file; its further states follow
_ESTIMATES = ("x1_hat", "x2_hat", "Delta_hat", "x3_hat", "u1_hat", "x4_hat", "u2_hat")


def save(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """The Dataset as NetCDF, its time series and its measures as CSV; the paths written."""
    stem = dataset.attrs["scenario"]
    paths = [folder / f"{stem}{ending}" for ending in (".nc", ".csv", "-measures.csv")]
    save_netcdf(dataset, paths[0])
    write_whole(paths[1], _time_series(dataset).encode())
    write_whole(paths[2], measures_csv(dataset).encode())
    return paths


def columns(dataset: xr.Dataset) -> Iterator[tuple[str, str, Array]]:
    """Name, unit and values of each column of the time series, in order."""
    observers = dataset.observer.values.tolist()
    yield "t", *_series(dataset.time)
    for state in STATES:
        yield state, *_series(dataset.x.sel(state=state))
    for observer in observers:
        for name in _ESTIMATES:
            yield f"{observer}.{name}", *_series(_estimate(dataset, observer, name))
        for variable in dataset.data_vars.values():
            if variable.attrs.get("observer") == observer:
                yield f"{observer}.{variable.attrs['state']}", *_series(variable)
    for name in ("u1", "u2", "Delta", "a1", "a2"):
        yield name, *_series(_truth(dataset, name))
    for observer in observers:
        for name in ("a1_hat", "a2_hat"):
            yield f"{observer}.{name}", *_series(_estimate(dataset, observer, name))
    for name in MEASURED:
        yield name, *_series(dataset.y.sel(sensor=name))
    if "r" in dataset:
        yield "r", *_series(dataset.r)


def measures_csv(dataset: xr.Dataset) -> str:
    """One row per estimator and quantity; empty where a measure is not defined."""
    keys = list(SENTENCES)
    rows = [
        [dataset.attrs["scenario"], dataset.attrs["seed"], estimator, quantity]
        + [_written(float(dataset[key].sel(estimator=estimator, quantity=quantity))) for key in keys]
        for estimator in dataset.estimator.values
        for quantity in dataset.quantity.values
    ]
    return _csv([["scenario", "seed", "observer", "quantity", *keys], *rows])


def _time_series(dataset: xr.Dataset) -> str:
    every = list(columns(dataset))
    units = "# units: " + ",".join(unit for _, unit, _ in every) + "\n"
    rows = np.stack([values for _, _, values in every], axis=1).tolist()
    return units + _csv([[name for name, _, _ in every], *([_written(value) for value in row] for row in rows)])


def _truth(dataset: xr.Dataset, name: str) -> xr.DataArray:
    return dataset["Delta"] if name == "Delta" else dataset[name[0]].sel(muscle=int(name[1]))


def _estimate(dataset: xr.Dataset, observer: str, name: str) -> xr.DataArray:
    of = dataset.sel(observer=observer)
    quantity = name.removesuffix(hat(""))
    if quantity == "Delta":
        return of["Delta_hat"]
    return of["x_hat"].sel(state=quantity) if quantity in STATES else of[hat(quantity[0])].sel(muscle=int(quantity[1]))


def _series(array: xr.DataArray) -> tuple[str, Array]:
    return array.attrs.get("units", "1"), array.values


def _csv(rows: list[list[str]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _written(value: float) -> str:
    """The shortest text that reads back as the same number; NaN is empty."""
    return "" if value != value else repr(value).removesuffix(".0")


def refuse_same_names(names: Sequence[str]) -> None:
    """ResultError if two results would be written under one name."""
    if double := sorted({name for name in names if names.count(name) > 1}):
        raise ResultError(f"two scenarios are called {double[0]}: their results would overwrite each other")
