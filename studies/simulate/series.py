"""One signal out of the Dataset of a run."""

from __future__ import annotations

import xarray as xr

from ...model.symbols import MUSCLES, hat, kind_of, muscle_of


def series(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """A quantity or its estimate, such as `x3` or `u1_hat`, out of the Dataset's arrays."""
    quantity = name.removesuffix(hat(""))
    kind = kind_of(quantity)
    variable = kind if kind in ("u", "a", "Delta") else "x"
    group = dataset[hat(variable) if name != quantity else variable]
    if "state" in group.dims:
        return group.sel(state=quantity)
    if "muscle" in group.dims:
        return group.sel(muscle=label_of(muscle_of(quantity)))
    return group.sel(joint=quantity.rpartition(".")[0]) if "joint" in group.dims else group


def label_of(muscle: str | None) -> int | str | None:
    """What the Dataset calls a muscle: those of the pair are 1 and 2."""
    return MUSCLES.index(muscle) + 1 if muscle in MUSCLES else muscle
