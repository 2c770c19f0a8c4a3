"""Estimates as files: NetCDF, CSV, OpenSim's .sto, and the scores."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import xarray as xr

from ..files.errors import ResultError
from ..files.netcdf import save_netcdf
from ..files.tables import Series, write_csv, write_sto
from ..files.writing import write_whole
from ..laboratory.columns import OPENSIM
from .scores import Score, scores_csv

_ALONE = ("position", "velocity", "disturbance")
_PER_MUSCLE = ("tendon_length", "fibre_length", "fibre_velocity", "activation")


def save_estimates(dataset: xr.Dataset, found: list[Score], folder: Path) -> list[Path]:
    """Write `estimates.nc`, `.csv`, an `.sto` per observer, and `scores.csv` if there are any; the paths written.

    The .sto files have the measured forces too, so each is a recording that can be read.
    """
    observers = dataset.observer.values.tolist()
    paths = [folder / "estimates.nc", folder / "estimates.csv"]
    save_netcdf(dataset, paths[0])
    time = Series("time", "s", dataset.time.values)
    position = Series("position", "m", dataset.position.values)
    forces = [Series(f"force_{j}", "N", dataset.force.sel(muscle=j).values) for j in (1, 2)]
    prefixes = {name: f"{name}." if len(observers) > 1 else "" for name in observers}
    every = [series for name, prefix in prefixes.items() for series in _series(dataset, name, prefix)]
    write_csv(paths[1], [time, position, *forces, *every])
    for name in observers:
        path = folder / ("estimates.sto" if len(observers) == 1 else f"estimates-{name}.sto")
        own = [Series(OPENSIM[series.name], series.unit, series.values) for series in (*forces, *_plain(dataset, name))]
        write_sto(path, f"estimates of {name} from {dataset.attrs['source']}", [time, *own])
        paths.append(path)
    if found:
        paths.append(folder / "scores.csv")
        write_whole(paths[-1], scores_csv(found).encode())
    return paths


def refuse_overwriting(inputs: Iterable[str], folder: Path) -> None:
    """ResultError if what is read is where `save_estimates` writes."""
    for path in map(Path, inputs):
        if path.resolve().parent == folder.resolve() and path.name.startswith(("estimates", "scores")):
            raise ResultError(f"{path} might be overwritten by its estimates; choose another folder with --out")


def _series(dataset: xr.Dataset, observer: str, prefix: str) -> Iterator[Series]:
    for series in _plain(dataset, observer):
        yield Series(f"{prefix}{series.name}_hat", series.unit, series.values)


def _plain(dataset: xr.Dataset, observer: str) -> Iterator[Series]:
    """The estimates by the names that columns of a recording have."""
    of = dataset.sel(observer=observer)
    for name in _ALONE:
        yield Series(name, of[f"{name}_hat"].attrs["units"], of[f"{name}_hat"].values)
    for name in _PER_MUSCLE:
        for j in (1, 2):
            values = of[f"{name}_hat"].sel(muscle=j)
            yield Series(f"{name}_{j}", values.attrs["units"], values.values)
