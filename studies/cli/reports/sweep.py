"""What a sweep has to say on a terminal: where the median error is smallest, what failed, which gains are too small."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import xarray as xr
from rich.table import Table
from rich.text import Text

from ....observers import label
from ...sweep.optimum import at_scenario, axes_of, best, free, medians, own_value, shown_of
from ...sweep.region import where
from .number import number

_SHOWN = ("x2", "Delta", "u1", "u2", "a1", "a2")


def optimum(dataset: xr.Dataset) -> Table:
    """For each observer and quantity the smallest median RMSE over the seeds, where it is, and the scenario's own."""
    paths, every = axes_of(dataset).paths, medians(dataset)
    compared = dataset.attrs["kind"] == "grid" and bool(paths)
    table = Table(box=None, padding=(0, 1, 0, 0))
    for heading in ("", "quantity", *paths, "median RMSE", *(["scenario's own"] if compared else [])):
        table.add_column(heading, no_wrap=True, justify="left" if heading in ("", "quantity") else "right")
    for observer in dataset.observer.values.tolist():
        for quantity in shown_of(dataset, _SHOWN):
            median = every.sel(observer=observer, quantity=quantity)
            if (found := best(dataset, median, observer)) is None:
                continue
            values = [f"{float(found[path]):.4g}" for path in paths]
            own = [number(at_scenario(dataset, median))] if compared else []
            table.add_row(Text(label(observer)), quantity, *values, number(float(found)), *own)
    return table


def notes(dataset: xr.Dataset) -> Iterator[str]:
    """Sentences above the table: how many runs, what failed, which gain conditions do not hold, what is compared."""
    runs = dataset.plant_failed_at.size
    yield f"{runs:,} run{'s' if runs > 1 else ''} of {dataset.attrs['scenario']}, {dataset.sizes['seed']:,} per point"
    yield from _failures(dataset, "the plant", dataset.plant_failed_at, dataset.plant_failure)
    for observer in dataset.observer.values.tolist():
        of = dataset.sel(observer=observer)
        yield from _failures(dataset, label(observer), of.failed_at, of.failure)
    for name, conditions in json.loads(dataset.attrs["violated_conditions"]).items():
        for condition in conditions:
            yield f"gain condition of {label(name)}: {condition}"
    yield from _comparison(dataset)


def _failures(dataset: xr.Dataset, who: str, times: xr.DataArray, causes: xr.DataArray) -> Iterator[str]:
    """How often, how early and where it failed, and the commonest cause with the points where it was the cause."""
    lost = int(times.notnull().sum())
    if not lost:
        return
    places = causes.values[causes.values > 0]
    most = int(np.bincount(places).argmax())
    name = str(causes.attrs["flag_meanings"]).split()[most]
    at = where(axes_of(dataset), (causes == most).any("seed").values.ravel())
    yield f"{who} failed in {lost:,} of them, first at τ = {float(times.min()):g}"
    yield f"  commonest cause: {name} ({(places == most).sum():,} runs), {at}"


def _comparison(dataset: xr.Dataset) -> Iterator[str]:
    """What the columns of the table mean where it is not plain."""
    axes = axes_of(dataset)
    if axes.kind != "grid" or not axes.paths:
        return
    own = {path: own_value(dataset, path) for path in axes.paths}
    inside = ", ".join(f"{path} = {value:g}" for path, value in own.items() if value is not None)
    if None not in own.values():
        yield f"scenario's own: {inside}, or the swept value nearest to it"
    tuned = {path for observer in dataset.observer.values.tolist() for path in free(dataset, observer)}
    held = [path for path in axes.paths if path not in tuned and own[path] is not None]
    if held:
        sought = ", ".join(path for path in axes.paths if path in tuned)
        yield f"smallest over {sought}, for the {', '.join(held)} nearest to the scenario's"
