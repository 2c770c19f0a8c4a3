"""What a panel shows: where the start of a run ends, whose errors hide what follows, and the limits of either part."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...model.arrays import Array
from ...model.symbols import hat, kind_of, muscle_of
from ..simulate.series import label_of, series
from .traces import with_margin

Limits = tuple[float, float]
Flags = NDArray[np.bool_]

# the rest gets its own scale if the start makes the range this many times larger
_HIDES = 1.8
# a share of the time: rarer spikes may leave the axes if they hide the rest
_SPIKES = 0.005
# of the range of the values, above and below them
_MARGIN = 0.06


def true(dataset: xr.Dataset, quantity: str) -> Array:
    """The true values over time as a panel shows them: an activation up to 1, none where the tendon is slack."""
    values = np.asarray(series(dataset, quantity))
    if kind_of(quantity) != "a":
        return values
    # the activation is 0/0 while the tendon is slack
    return np.where(slack(dataset, quantity), np.nan, np.minimum(values, 1))


def infeasible(dataset: xr.Dataset, quantity: str) -> Flags:
    """True at the times at which a muscle would need an activation above 1 for what it does."""
    if kind_of(quantity) != "a":
        return np.zeros(dataset.sizes["time"], dtype=bool)
    return np.asarray(~slack(dataset, quantity) & (series(dataset, quantity).values > 1), dtype=bool)


def slack(dataset: xr.Dataset, quantity: str) -> Flags:
    """True at the times at which the tendon that `quantity` belongs to carries no force."""
    muscle = muscle_of(quantity)
    if muscle is None:
        return np.zeros(dataset.sizes["time"], dtype=bool)
    return np.asarray(dataset["taut"].sel(muscle=label_of(muscle)) == 0, dtype=bool)


def start(dataset: xr.Dataset) -> float:
    """The end of the start: a round time before the middle of the run, or 0 if nothing stands out there.

    It is the knee of the error bound: time given away and size of the errors still to come, both as shares of
    the whole, are least together.
    """
    time = np.asarray(dataset["time"])
    shares = [share for quantity in dataset.quantity.values.tolist() for share in _errors_to_come(dataset, quantity)]
    if not shares or time[-1] == 0:
        return 0.0
    knee = _round_up(time[np.argmin(time / time[-1] + np.mean(shares, axis=0))])
    return knee if knee <= time[-1] / 2 else 0.0


def limits(dataset: xr.Dataset, quantity: str, end: float) -> list[Limits]:
    """The limits of the start and of the rest, or one for both where both can be read in it."""
    time = np.asarray(dataset["time"])
    whole, first, later = (_lines(dataset, quantity, when) for when in (time >= 0, time <= end, time >= end))
    narrow = _without_spikes(later)
    if end == 0 or np.ptp(_range(whole)) <= _HIDES * np.ptp(narrow):
        return [_range(whole)]
    return [_range(first), narrow]


def _errors_to_come(dataset: xr.Dataset, quantity: str) -> list[Array]:
    """Per observer the largest |error| from each time on, as a share of the largest; the slack does not count."""
    estimates = np.asarray(series(dataset, hat(quantity)).transpose("observer", "time"))
    with np.errstate(over="ignore"):
        errors = np.where(slack(dataset, quantity), 0.0, np.abs(estimates - true(dataset, quantity)))
    bounds = np.maximum.accumulate(errors[:, ::-1], axis=1)[:, ::-1]
    # an observer that fails has no start that ends
    return [bound / bound[0] for bound in bounds if 0 < bound[0] < math.inf]


def _round_up(value: float) -> float:
    """The next 1, 2 or 5 × 10ⁿ."""
    if value <= 0:
        return 0.0
    power = 10.0 ** math.floor(math.log10(value))
    return float(next(step * power for step in (1, 2, 5, 10) if value <= step * power * (1 + 1e-9)))


def _lines(dataset: xr.Dataset, quantity: str, when: Flags) -> list[Array]:
    """The finite values of each line; of an observer that fails only the first half, for it ends without bounds."""
    lines = [true(dataset, quantity)[when]]
    for estimate in np.asarray(series(dataset, hat(quantity)).transpose("observer", "time")):
        life = int(np.isfinite(estimate).sum())
        trusted = when & (np.arange(len(when)) <= (len(when) if life == len(when) else life // 2))
        lines.append(estimate[trusted])
    return [line[np.isfinite(line)] for line in lines]


def _range(lines: Sequence[Array]) -> Limits:
    """Limits that show all of the lines."""
    return with_margin(np.concatenate(lines), _MARGIN)


def _without_spikes(lines: Sequence[Array]) -> Limits:
    """Limits that show all of the lines but for rare spikes that would hide the rest."""
    everything, most = _range(lines), _range([_middle(line, _SPIKES) for line in lines])
    return most if np.ptp(everything) > _HIDES * np.ptp(most) else everything


def _middle(values: Array, share: float) -> Array:
    """The two values that leave out `share` at either end."""
    return np.quantile(values, [share, 1 - share]) if values.size else values
