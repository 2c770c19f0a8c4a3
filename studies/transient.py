"""Where the start of a run ends: the first estimation errors are so large that they hide what follows."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from ..codegen.library import Array
from ..model.symbols import QUANTITIES, hat, muscle_of


def series(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """A quantity or its estimate, such as `x3` or `u1_hat`, out of the Dataset's arrays."""
    quantity, _, suffix = name.partition("_")
    group = dataset[hat(_GROUP[quantity]) if suffix else _GROUP[quantity]]
    if "state" in group.dims:
        return group.sel(state=quantity)
    return group.sel(muscle=int(quantity[-1])) if "muscle" in group.dims else group


_GROUP = {quantity: quantity if quantity == "Delta" else quantity[0] for quantity in QUANTITIES}


def slack(dataset: xr.Dataset, quantity: str) -> Array:
    """True at the times at which the tendon that `quantity` belongs to carries no force."""
    muscle = muscle_of(quantity)
    if muscle is None:
        return np.zeros(dataset.sizes["time"], dtype=bool)
    return np.asarray(dataset["taut"].sel(muscle=int(muscle[-1])) == 0)


def start(dataset: xr.Dataset) -> float:
    """The end of the start: a round time before the middle of the run, or 0 if nothing stands out there.

    It is the knee of the error bound: time given away and size of the errors still to come, both as shares of
    the whole, are least together.
    """
    time = np.asarray(dataset["time"])
    shares = [share for quantity in QUANTITIES for share in _errors_to_come(dataset, quantity)]
    if not shares or time[-1] == 0:
        return 0.0
    knee = _round_up(time[np.argmin(time / time[-1] + np.mean(shares, axis=0))])
    return knee if knee <= time[-1] / 2 else 0.0


def _errors_to_come(dataset: xr.Dataset, quantity: str) -> list[Array]:
    """Per observer the largest |error| from each time on, as a share of the largest; the slack does not count."""
    true, estimates = series(dataset, quantity), series(dataset, hat(quantity)).transpose("observer", "time")
    with np.errstate(over="ignore"):
        errors = np.where(slack(dataset, quantity), 0.0, np.abs(np.asarray(estimates - true)))
    bounds = np.maximum.accumulate(errors[:, ::-1], axis=1)[:, ::-1]
    # an observer that fails has no start that ends
    return [bound / bound[0] for bound in bounds if 0 < bound[0] < math.inf]


def _round_up(value: float) -> float:
    """The next 1, 2 or 5 × 10ⁿ."""
    if value <= 0:
        return 0.0
    power = 10.0 ** math.floor(math.log10(value))
    return float(next(step * power for step in (1, 2, 5, 10) if value <= step * power * (1 + 1e-9)))
