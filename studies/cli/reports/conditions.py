"""Which gain conditions do not hold."""

from __future__ import annotations

import json
from collections.abc import Iterator

import xarray as xr

from ....observers import label


def violated_conditions(dataset: xr.Dataset) -> Iterator[str]:
    """A sentence for each of a run or of estimates, with both numbers."""
    for name, conditions in json.loads(dataset.attrs["violated_conditions"]).items():
        for condition in conditions:
            yield f"gain condition of {label(name)}: {condition}"
