"""How far estimates are from the truth, where a recording knows it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from ..files.tables import csv_text
from .dataset import joint_units

# seconds from the first sample on in which observers settle
SETTLED = 1.0
# standard deviations to either side that hold 95 % of a normal distribution
WITHIN_95 = 1.96
# what observers estimate of a recording, scored where the truth is known
ESTIMATED = ("position", "velocity", "disturbance", "tendon_length", "fibre_length", "fibre_velocity", "activation")
_HEADER = ("observer", "quantity", "muscle", "unit", "rmse", "peak")


@dataclass(frozen=True)
class Score:
    """Root mean square and largest error after SETTLED, in `unit`.

    muscle: 1, 2, both or empty of a pair; the name of a muscle or joint of a mechanism, all muscles or all joints.
    joint: whether it is of joints that have names; together: of all of them, all muscles, or what has no parts.
    """

    observer: str
    quantity: str
    muscle: str
    unit: str
    rmse: float
    peak: float
    joint: bool = field(default=False, kw_only=True)
    together: bool = field(default=False, kw_only=True)

    def row(self) -> dict[str, str | float]:
        """What tables have of it, by column."""
        return {name: getattr(self, name) for name in _HEADER}


def scores(dataset: xr.Dataset) -> list[Score]:
    """All that can be compared, by observer, quantity and muscle; none if the recording knows nothing."""
    return list(_scores(dataset.sel(time=slice(float(dataset.time[0]) + SETTLED, None))))


def scores_csv(scores: list[Score]) -> str:
    """A row per score."""
    return csv_text([_HEADER, *(tuple(score.row().values()) for score in scores)])


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
            dim = next((dim for dim in ("muscle", "joint") if dim in error.dims), "")
            joint, unit = dim == "joint", str(estimates.attrs["units"])
            own = joint_units(late, f"{quantity}_hat") if joint else {}
            # no mean of metres and radians
            together = _together(late, dim) if len(set(own.values())) <= 1 else None
            parts = {} if together is None else {together: error}
            parts |= {str(label): error.sel({dim: label}) for label in (error[dim].values.tolist() if dim else ())}
            # the force that moves a prescribed joint is not known
            told = {name: part for name, part in parts.items() if observer in failed or part.notnull().any()}
            for muscle, part in told.items():
                rmse, peak = float(np.sqrt((part**2).mean())), float(np.abs(part).max())
                if observer in failed:
                    rmse = peak = math.nan
                yield Score(
                    observer,
                    quantity,
                    muscle,
                    own.get(muscle, unit),
                    rmse,
                    peak,
                    joint=joint,
                    together=muscle == together,
                )


def _together(late: xr.Dataset, dim: str) -> str:
    """What all joints or all muscles are called: two words where they have names, which no name is."""
    if not dim:
        return ""
    return f"all {dim}s" if "joint" in late.dims else "both"
