"""How far estimates are from the truth, where a recording knows it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import astuple, dataclass, fields

import numpy as np
import xarray as xr

from ..files.tables import csv_text

# seconds from the first sample on in which observers settle
SETTLED = 1.0
# standard deviations to either side that hold 95 % of a normal distribution
WITHIN_95 = 1.96
# what observers estimate of a recording, scored where the truth is known
ESTIMATED = ("position", "velocity", "disturbance", "tendon_length", "fibre_length", "fibre_velocity", "activation")
# all joints or all muscles together, and what has no parts
TOGETHER = ("", "both", "all")


@dataclass(frozen=True)
class Score:
    """Root mean square and largest error after SETTLED, in `unit`.

    muscle: 1, 2, both or empty of a pair; the name of a muscle or joint of a mechanism, or all.
    """

    observer: str
    quantity: str
    muscle: str
    unit: str
    rmse: float
    peak: float


_HEADER = tuple(field.name for field in fields(Score))


def scores(dataset: xr.Dataset) -> list[Score]:
    """All that can be compared, by observer, quantity and muscle; none if the recording knows nothing."""
    return list(_scores(dataset.sel(time=slice(float(dataset.time[0]) + SETTLED, None))))


def scores_csv(scores: list[Score]) -> str:
    """A row per score."""
    return csv_text([_HEADER, *map(astuple, scores)])


def _scores(late: xr.Dataset) -> Iterator[Score]:
    if late.sizes["time"] == 0:
        return
    failed = json.loads(late.attrs["failures"])
    for observer in late.observer.values.tolist():
        for quantity in ESTIMATED:
            if f"true_{quantity}" not in late:
                continue
            estimates = late[f"{quantity}_hat"]
            error = estimates.sel(observer=observer) - late[f"true_{quantity}"]
            parts = {"": error}
            for dim in {"muscle", "joint"} & set(error.dims):
                labels = error[dim].values.tolist()
                together = "both" if len(labels) == 2 else "all"
                parts = {together: error, **{str(label): error.sel({dim: label}) for label in labels}}
            # the force that moves a prescribed joint is not known
            told = {name: part for name, part in parts.items() if observer in failed or part.notnull().any()}
            for muscle, part in told.items():
                rmse, peak = float(np.sqrt((part**2).mean())), float(np.abs(part).max())
                if observer in failed:
                    rmse = peak = math.nan
                yield Score(observer, quantity, muscle, estimates.attrs["units"], rmse, peak)
