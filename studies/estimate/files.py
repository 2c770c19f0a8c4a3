"""Estimates as files: NetCDF, CSV, OpenSim's .sto, and the scores."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import xarray as xr

from ..files.datasets.netcdf import save_netcdf
from ..files.pictures import WITH_PDF, figure_paths
from ..files.progress import Progress, shares, unseen
from ..files.tables import Series, write_csv, write_sto
from ..files.writing import refuse_overwriting, refuse_read, remove_ours, write_whole
from ..laboratory.subject import subject_again
from .dataset import joint_units
from .scores import ESTIMATED, Score, scores_csv

# the figure of estimates, and what its files begin with
SHEET, STEM = "sheet", "estimates"
_TITLE = "estimates of {observer} from {source}"
_SCORES, _REPORT = "scores.csv", "estimates.html"
# what follows the name of an estimate; the part from noise follows from the other two
_HAT, _DEVIATIONS = "_hat", ("_sd", "_sd_muscle")


def estimate_paths(folder: Path, observers: Sequence[str], scored: bool) -> list[Path]:
    """The files of the estimates of some observers: `estimates.nc`, `.csv`, an `.sto` of each, and the scores."""
    alone = len(observers) == 1
    names = ["estimates.sto" if alone else f"estimates-{name}.sto" for name in observers]
    return [folder / name for name in ("estimates.nc", "estimates.csv", *names, *[_SCORES] * scored)]


def report_path(folder: Path) -> Path:
    """The file of the report."""
    return folder / _REPORT


def save_estimates(dataset: xr.Dataset, scores: list[Score], folder: Path, progress: Progress = unseen) -> list[Path]:
    """Write `estimates.nc`, `.csv`, an `.sto` per observer, and `scores.csv` if there are any; the paths written.

    The .sto files have the measured forces too, so each is a recording that can be read. What an earlier run has left
    there of other observers, its report and figures, and scores where there are none now, are removed; nothing that we
    have not written is.
    """
    observers = dataset.observer.values.tolist()
    paths = estimate_paths(folder, observers, bool(scores))
    netcdf, table, *of_observers = paths
    parts = shares(progress, [1] * (2 + len(observers)))
    save_netcdf(dataset, netcdf)
    next(parts)(1.0)
    time = Series("time", "s", dataset.time.values)
    subject = subject_again(json.loads(str(dataset.muscle_file.values)))
    names, opensim = subject.names, subject.columns.opensim
    positions, forces = (list(_parts(dataset, name, names[name])) for name in ("position", "force"))
    prefixes = {name: f"{name}." if len(observers) > 1 else "" for name in observers}
    estimates = [
        Series(f"{prefix}{column}{suffix}", values.attrs["units"], values.values)
        for name, prefix in prefixes.items()
        for column, suffix, values in _columns(dataset, name, names)
    ]
    write_csv(table, [time, *(Series(c, v.attrs["units"], v.values) for c, v in (*positions, *forces)), *estimates])
    next(parts)(1.0)
    for name, path in zip(observers, of_observers, strict=False):
        columns = [Series(opensim[column], values.attrs["units"], values.values) for column, values in forces]
        columns += [
            Series(opensim[column] + suffix.removeprefix(_HAT), values.attrs["units"], values.values)
            for column, suffix, values in _columns(dataset, name, names)
        ]
        write_sto(path, _TITLE.format(observer=name, source=dataset.attrs["source"]), [time, *columns])
        next(parts)(1.0)
    if scores:
        write_whole(of_observers[-1], scores_csv(scores).encode())
    for path in _leftovers(folder, paths):
        remove_ours(path)
    return paths


def save_again(dataset: xr.Dataset, folder: Path) -> None:
    """Write `estimates.nc` anew: what was found out about the estimates since is in the attributes of the Dataset."""
    netcdf, *_ = estimate_paths(folder, [], scored=False)
    save_netcdf(dataset, netcdf)


def refuse_replacing(folder: Path, paths: Sequence[Path]) -> None:
    """ResultError if one of the `paths` to be written, or a leftover in their `folder`, must stay as it is."""
    refuse_overwriting(paths)
    refuse_read(_leftovers(folder, paths))


def _leftovers(folder: Path, written: Sequence[Path]) -> list[Path]:
    """What would pass for a part of the new result if an earlier run has written it."""
    figures = figure_paths(folder, STEM, [SHEET], WITH_PDF)
    candidates = [*sorted(folder.glob("estimates*.sto")), folder / _SCORES, report_path(folder), *figures]
    return [path for path in candidates if path not in written]


def _columns(
    dataset: xr.Dataset, observer: str, names: Mapping[str, tuple[str, ...]]
) -> Iterator[tuple[str, str, xr.DataArray]]:
    """The estimates by the names that columns of a recording have, then their standard deviations, if known."""
    of = dataset.sel(observer=observer)
    for suffix, name in itertools.product((_HAT, *_DEVIATIONS), ESTIMATED):
        if suffix in _DEVIATIONS and (name + suffix not in of or of[name + suffix].isnull().all()):
            continue
        yield from ((column, suffix, part) for column, part in _parts(of, name + suffix, names[name]))


def _parts(dataset: xr.Dataset, variable: str, names: Sequence[str]) -> Iterator[tuple[str, xr.DataArray]]:
    """The column of each joint or muscle, with its unit."""
    values = dataset[variable]
    if "joint" in values.dims:
        for column, (joint, unit) in zip(names, joint_units(dataset, variable).items(), strict=True):
            yield column, values.sel(joint=joint).assign_attrs(units=unit)
    elif "muscle" in values.dims:
        for column, muscle in zip(names, values.muscle.values.tolist(), strict=True):
            yield column, values.sel(muscle=muscle)
    else:
        yield names[0], values
