"""Estimates as files: NetCDF, CSV, OpenSim's .sto, and the scores."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import xarray as xr

from ..files.errors import ResultError
from ..files.netcdf import LARGEST_RESULT, save_netcdf
from ..files.reading import cause, open_regular
from ..files.tables import Series, write_csv, write_sto
from ..files.writing import write_whole
from ..laboratory.columns import OPENSIM
from .scores import ESTIMATED, HEADER, Score, scores_csv

# the first line of an .sto file of ours
_TITLE = "estimates of {observer} from {source}"
_OURS = re.compile(_TITLE.format(observer=r"(?P<observer>\w+)", source=r".+"))
_SCORES = "scores.csv"
# bytes; a file name and a few words
_LONGEST_LINE = 10_000


def save_estimates(dataset: xr.Dataset, scores: list[Score], folder: Path) -> list[Path]:
    """Write `estimates.nc`, `.csv`, an `.sto` per observer, and `scores.csv` if there are any; the paths written.

    The .sto files have the measured forces too, so each is a recording that can be read. What an earlier run has left
    there of other observers, or scores where there are none now, is removed; nothing that we have not written is.
    """
    observers = dataset.observer.values.tolist()
    paths = [folder / "estimates.nc", folder / "estimates.csv"]
    save_netcdf(dataset, paths[0])
    time = Series("time", "s", dataset.time.values)
    position = Series("position", "m", dataset.position.values)
    forces = [Series(f"force_{j}", "N", dataset.force.sel(muscle=j).values) for j in (1, 2)]
    prefixes = {name: f"{name}." if len(observers) > 1 else "" for name in observers}
    estimates = [series for name, prefix in prefixes.items() for series in _series(dataset, name, prefix)]
    write_csv(paths[1], [time, position, *forces, *estimates])
    for name in observers:
        path = folder / ("estimates.sto" if len(observers) == 1 else f"estimates-{name}.sto")
        columns = [Series(OPENSIM[s.name], s.unit, s.values) for s in (*forces, *_plain(dataset, name))]
        write_sto(path, _TITLE.format(observer=name, source=dataset.attrs["source"]), [time, *columns])
        paths.append(path)
    if scores:
        paths.append(folder / _SCORES)
        write_whole(paths[-1], scores_csv(scores).encode())
    _remove_stale(folder, paths)
    return paths


def refuse_overwriting(inputs: Iterable[str], folder: Path) -> None:
    """ResultError if what is read is where `save_estimates` writes."""
    for path in map(Path, inputs):
        if path.resolve().parent == folder.resolve() and path.name.startswith(("estimates", "scores")):
            raise ResultError(f"{path} might be overwritten by its estimates; choose another folder with --out")


def _remove_stale(folder: Path, written: list[Path]) -> None:
    """Remove what would pass for a part of the new result; ResultError if that cannot be."""
    for path in (*folder.glob("estimates*.sto"), folder / _SCORES):
        if path not in written and _is_ours(path):
            try:
                path.unlink(missing_ok=True)
            except OSError as error:
                raise ResultError(f"{path} is of an earlier run and cannot be removed: {cause(error)}") from error


def _is_ours(path: Path) -> bool:
    """Whether the first line is one that `save_estimates` writes under this name."""
    line = b""
    with contextlib.suppress(OSError, ValueError), open_regular(path, LARGEST_RESULT) as (file, _):
        line = file.readline(_LONGEST_LINE).rstrip(b"\n")
    if path.name == _SCORES:
        return line == ",".join(HEADER).encode()
    title = _OURS.fullmatch(line.decode(errors="replace"))
    return title is not None and path.name in ("estimates.sto", f"estimates-{title['observer']}.sto")


def _series(dataset: xr.Dataset, observer: str, prefix: str) -> Iterator[Series]:
    for series in _plain(dataset, observer):
        yield Series(f"{prefix}{series.name}_hat", series.unit, series.values)


def _plain(dataset: xr.Dataset, observer: str) -> Iterator[Series]:
    """The estimates by the names that columns of a recording have."""
    of = dataset.sel(observer=observer)
    for name in ESTIMATED:
        estimate = of[f"{name}_hat"]
        parts = {name: estimate}
        if "muscle" in estimate.dims:
            parts = {f"{name}_{j}": estimate.sel(muscle=j) for j in (1, 2)}
        for column, values in parts.items():
            yield Series(column, values.attrs["units"], values.values)
