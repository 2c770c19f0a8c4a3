"""A run as files: NetCDF, its time series and its measures as CSV."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from ...model.symbols import MEASURED, STATES, hat
from ..files.datasets.netcdf import save_netcdf
from ..files.tables import Series, csv_text, or_empty, write_csv
from ..files.writing import write_whole
from .measures import SENTENCES

# an observer's estimates in the order of a CSV file; its further states follow
_ESTIMATES = ("x1_hat", "x2_hat", "Delta_hat", "x3_hat", "u1_hat", "x4_hat", "u2_hat")


def run_paths(folder: Path, stem: str) -> list[Path]:
    """The files of the run that is called `stem`: NetCDF, time series, measures."""
    return [folder / f"{stem}{ending}" for ending in (".nc", ".csv", "-measures.csv")]


def save(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """The Dataset as NetCDF, its time series and its measures as CSV; the paths written."""
    paths = run_paths(folder, dataset.attrs["run"])
    save_netcdf(dataset, paths[0])
    write_csv(paths[1], list(columns(dataset)))
    write_whole(paths[2], measures_csv(dataset).encode())
    return paths


def columns(dataset: xr.Dataset) -> Iterator[Series]:
    """The columns of the time series, in order; everything is dimensionless, so names stand alone."""
    observers = dataset.observer.values.tolist()
    yield _series("t", dataset.time)
    for state in STATES:
        yield _series(state, dataset.x.sel(state=state))
    for observer in observers:
        for name in _ESTIMATES:
            yield _series(f"{observer}.{name}", _estimate(dataset, observer, name))
        for variable in dataset.data_vars.values():
            if variable.attrs.get("observer") == observer:
                yield _series(f"{observer}.{variable.attrs['state']}", variable)
    for name in ("u1", "u2", "Delta", "a1", "a2"):
        yield _series(name, _truth(dataset, name))
    for observer in observers:
        for name in ("a1_hat", "a2_hat"):
            yield _series(f"{observer}.{name}", _estimate(dataset, observer, name))
    for name in MEASURED:
        yield _series(name, dataset.y.sel(sensor=name))
    if "r" in dataset:
        yield _series("r", dataset.r)


def measures_csv(dataset: xr.Dataset) -> str:
    """One row per estimator and quantity; empty where a measure is not defined."""
    keys = list(SENTENCES)
    rows = [
        [dataset.attrs["scenario"], dataset.attrs["seed"], estimator, quantity]
        + [or_empty(float(dataset[key].sel(estimator=estimator, quantity=quantity))) for key in keys]
        for estimator in dataset.estimator.values
        for quantity in dataset.quantity.values
    ]
    return csv_text([["scenario", "seed", "observer", "quantity", *keys], *rows])


def _truth(dataset: xr.Dataset, name: str) -> xr.DataArray:
    return dataset["Delta"] if name == "Delta" else dataset[name[0]].sel(muscle=int(name[1]))


def _estimate(dataset: xr.Dataset, observer: str, name: str) -> xr.DataArray:
    of = dataset.sel(observer=observer)
    quantity = name.removesuffix(hat(""))
    if quantity == "Delta":
        return of["Delta_hat"]
    return of["x_hat"].sel(state=quantity) if quantity in STATES else of[hat(quantity[0])].sel(muscle=int(quantity[1]))


def _series(name: str, array: xr.DataArray) -> Series:
    return Series(name, "1", array.values)
