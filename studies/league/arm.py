"""The observers of an arm: six muscles and two joints, as many chains, one table."""

from __future__ import annotations

from collections.abc import Sequence

import xarray as xr

from ...model.symbols import kind_of
from ...observers import OBSERVERS
from ..scenarios.prepare import BASELINE
from ..sweep.run import sweep

SOURCE = "arm"


def arm(seeds: Sequence[int]) -> xr.DataArray:
    """(observer, kind of quantity, seed) errors with usual gains, root mean squares over joints or muscles.

    Of the observers that are made of chains, and of the baseline. NaN where one of them fails.
    """
    return by_kind(sweep(SOURCE, {}, seeds, [*(name for name, one in OBSERVERS.items() if one.chains), BASELINE]).rmse)


def by_kind(rmse: xr.DataArray) -> xr.DataArray:
    """(seed, observer, quantity), such as `elbow.dq`, with all quantities of a kind as one."""
    kinds = [kind_of(name) for name in rmse["quantity"].values.tolist()]
    squares = (rmse**2).assign_coords(quantity=kinds).groupby("quantity").mean("quantity", skipna=False)
    return squares.sel(quantity=list(dict.fromkeys(kinds))) ** 0.5
