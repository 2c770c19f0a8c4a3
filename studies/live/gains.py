"""What estimates of a recording know for those that come live: gains, and the period they are for."""

from __future__ import annotations

import xarray as xr

from ..files.datasets.schema import read_json
from ..files.errors import ScenarioError


def gains_of_estimates(dataset: xr.Dataset, observer: str) -> dict[str, float]:
    """Path → value of the gains of an observer. ScenarioError if it is not among them, ResultError if it has none."""
    of_each: dict[str, dict[str, float]] = read_json(
        "gains", str(dataset.attrs.get("gains")), dict[str, dict[str, float]]
    )
    if observer not in of_each:
        those = ", ".join(of_each) or "no observer"
        raise ScenarioError(f"the estimates are those of {those}, and have no gains of {observer}")
    return of_each[observer]


def period_of_estimates(dataset: xr.Dataset) -> float:
    """In s from sample to sample. ResultError if it is not there."""
    return float(read_json("period", str(dataset.attrs.get("period")), float))
