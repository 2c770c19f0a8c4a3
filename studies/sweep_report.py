"""What a sweep has to say on a terminal: where the median error is smallest, and what failed."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import xarray as xr
from rich.table import Table
from rich.text import Text

from ..observers import label
from .report import number

_SHOWN = ("x2", "Delta", "u1", "u2", "a1", "a2")


def optimum(dataset: xr.Dataset) -> Table:
    """For each observer and quantity, the values with the smallest median RMSE over the seeds."""
    paths = json.loads(dataset.attrs["axes"])
    table = Table(box=None, padding=(0, 1, 0, 0))
    for heading in ("", "quantity", *paths, "median RMSE"):
        table.add_column(heading, no_wrap=True, justify="left" if heading in ("", "quantity") else "right")
    median = dataset.rmse.median("seed")
    for observer in dataset.observer.values.tolist():
        for quantity in _SHOWN:
            errors = median.sel(observer=observer, quantity=quantity)
            if not errors.notnull().any():
                continue
            best = errors.isel({k: int(v) for k, v in errors.argmin(...).items()}) if errors.dims else errors
            where = [f"{float(best[path]):.4g}" for path in paths]
            table.add_row(Text(label(observer)), quantity, *where, number(float(best)))
    return table


def notes(dataset: xr.Dataset) -> Iterator[str]:
    """Sentences below the table: how many runs, how many failed, and since when."""
    runs = dataset.plant_failed_at.size
    yield f"{runs:,} run{'s' if runs > 1 else ''} of {dataset.attrs['scenario']}, {dataset.sizes['seed']:,} per point"
    if lost := int(dataset.plant_failed_at.notnull().sum()):
        yield f"the plant failed in {lost:,} of them, first at τ = {float(dataset.plant_failed_at.min()):g}"
    for observer in dataset.observer.values.tolist():
        times = dataset.failed_at.sel(observer=observer).values
        if lost := int(np.isfinite(times).sum()):
            yield f"{label(observer)} failed in {lost:,} of them, first at τ = {np.nanmin(times):g}"
