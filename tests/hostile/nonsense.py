"""Finite nonsense: numbers in results that are infinite, or beyond all sizes of what they stand for."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np
import xarray as xr

# what a sentence about the result of a program begins with
NONSENSE = "nonsense: "
# an estimate may be a million times the largest true or measured number of its kind, or 1, and no more
BEYOND = 1e6
# a measure that exists at one of two steps only has an error without end
_MAY_BE_INFINITE = "_step_error"
# what estimates are compared with
_SIZES = {
    "x_hat": ("x",),
    "u_hat": ("u",),
    "a_hat": ("a",),
    "Delta_hat": ("Delta",),
    "position_hat": ("position",),
    "velocity_hat": ("position", "true_velocity"),
    "disturbance_hat": ("force", "true_disturbance"),
    "tendon_length_hat": ("position",),
    "fibre_length_hat": ("position",),
    "fibre_velocity_hat": ("position", "true_velocity"),
    "activation_hat": (),
}


def nonsense_in(result: object) -> Iterator[str]:
    """A sentence for each variable of a result that is infinite or too large."""
    if not isinstance(result, xr.Dataset):
        return
    for name, variable in result.data_vars.items():
        if variable.dtype.kind != "f":
            continue
        if np.isinf(variable.values).any() and not str(name).endswith(_MAY_BE_INFINITE):
            yield f"{name} is infinite"
        size = max([1.0, *(_largest(result[known]) for known in _SIZES.get(str(name), ()) if known in result)])
        if name in _SIZES and (largest := _largest(variable)) > BEYOND * size:
            yield f"{name} reaches {largest:.3g}, where what it stands for is at most {size:.3g}"


_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")


def nonsense_told(told: str, known: str) -> Iterator[str]:
    """A sentence if a number among estimates is too large beside all numbers that are known."""
    size, largest = max(1.0, _largest_of(known)), _largest_of(told)
    if largest > BEYOND * size:
        yield f"{largest:.3g} is told as an estimate, where all that is known is at most {size:.3g}"


def _largest_of(text: str) -> float:
    return max((abs(x) for x in map(float, _NUMBER.findall(text)) if math.isfinite(x)), default=0.0)


def lost(result: xr.Dataset) -> bool:
    """Whether estimates, or runs of a sweep, have ended before their time."""
    ended = [name for name in ("failed_at", "plant_failed_at") if name in result and result[name].notnull().any()]
    return bool(ended) or any(name in result and result[name].isnull().any() for name in _SIZES)


def _largest(variable: xr.DataArray) -> float:
    finite = variable.values[np.isfinite(variable.values)]
    return float(np.abs(finite).max()) if finite.size else 0.0
