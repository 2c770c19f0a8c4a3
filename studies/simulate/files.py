"""A run as files: NetCDF, its time series and its measures as CSV."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from ...model.symbols import hat, kind_of, owner_of
from ..files.datasets.netcdf import save_netcdf
from ..files.pictures import WITH_PDF, figure_paths
from ..files.tables import Series, csv_text, or_empty, write_csv
from ..files.writing import remove_ours, write_whole
from .measures import SENTENCES, numbers
from .recording import recording_columns
from .schema import FILE
from .series import series

# the figures of a run
FIGURES = ("phi_s", "reference", "states", "inputs", "activations")


def run_paths(folder: Path, stem: str, mechanism: bool) -> list[Path]:
    """The files of the run that is called `stem`: NetCDF, time series, measures, and of a mechanism a recording."""
    endings = [".nc", ".csv", "-measures.csv", *["-recording.csv"] * mechanism]
    return [folder / f"{stem}{ending}" for ending in endings]


def save(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """The Dataset as NetCDF, its time series and its measures as CSV; the paths written.

    That of a mechanism as a recording too, which `estimate` reads. The figures that we have drawn of an earlier run of
    this name are removed: they would pass for those of this one.
    """
    mechanism = FILE in dataset
    paths = run_paths(folder, dataset.attrs["run"], mechanism)
    for path in figure_paths(folder, dataset.attrs["run"], FIGURES, WITH_PDF):
        remove_ours(path)
    save_netcdf(dataset, paths[0])
    write_csv(paths[1], list(columns(dataset)))
    write_whole(paths[2], measures_csv(dataset).encode())
    if mechanism:
        write_csv(paths[3], list(recording_columns(dataset)))
    return paths


def columns(dataset: xr.Dataset) -> Iterator[Series]:
    """The columns of the time series, in order; everything is dimensionless, so names stand alone."""
    observers, quantities = dataset.observer.values.tolist(), dataset.quantity.values.tolist()
    states = dataset.state.values.tolist()
    activations = [name for name in quantities if kind_of(name) == "a"]
    inputs = [name for name in quantities if name not in states and name not in activations]
    # what belongs to the same joint or muscle stands together
    owners = list(dict.fromkeys(map(owner_of, quantities)))
    estimated = sorted([*states, *inputs], key=lambda name: (owners.index(owner_of(name)), quantities.index(name)))
    # inputs of muscles stand before those of joints
    inputs.sort(key=lambda name: kind_of(name) != "u")
    yield _series("t", dataset.time)
    for state in states:
        yield _series(state, dataset.x.sel(state=state))
    for observer in observers:
        of = dataset.sel(observer=observer)
        for name in estimated:
            yield _series(f"{observer}.{hat(name)}", series(of, hat(name)))
        for variable in dataset.data_vars.values():
            if variable.attrs.get("observer") == observer:
                yield _series(f"{observer}.{variable.attrs['state']}", variable)
    for name in [*inputs, *activations]:
        yield _series(name, series(dataset, name))
    for observer in observers:
        for name in activations:
            yield _series(f"{observer}.{hat(name)}", series(dataset.sel(observer=observer), hat(name)))
    for name in dataset.sensor.values.tolist():
        yield _series(name, dataset.y.sel(sensor=name))
    if "place" in dataset:
        for name in dataset.place.values.tolist():
            yield _series(f"r.{name}", dataset.r.sel(place=name))
    elif "r" in dataset:
        yield _series("r", dataset.r)


def measures_csv(dataset: xr.Dataset) -> str:
    """One row per estimator and quantity; empty where a measure is not defined."""
    measures = {key: numbers(dataset[key]) for key in SENTENCES}
    rows = [
        [dataset.attrs["scenario"], dataset.attrs["seed"], *of, *(or_empty(each[of]) for each in measures.values())]
        for of in measures["rmse"]
    ]
    return csv_text([["scenario", "seed", "observer", "quantity", *measures], *rows])


def _series(name: str, array: xr.DataArray) -> Series:
    return Series(name, "1", array.values)
