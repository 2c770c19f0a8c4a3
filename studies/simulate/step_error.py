"""How good the step is: what half of it changes in each measure."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...model.arrays import Array

# E(h) − E = 2ᵖ/(2ᵖ − 1) (E(h) − E(h/2)) for an error of the order p: 16/15 for a smooth run, 4/3 for noise that is
# held, and 2, the most, for jumps: an edge of slackness, a dead zone
_RICHARDSON = 2.0
# relative; below it the two digits of a table stay as they are, or nearly
SHOWN_FROM = 0.01
# a smaller measure of what is of the order of 1 is rounding, whatever the step
_ROUNDING = 1e-12


def step_error(measured: ArrayLike, halved: ArrayLike) -> Array:
    """What the step contributes to a measure at h, from the same measure at h/2: arrays of one shape.

    NaN where the measure is defined at neither step, ∞ where at one of them only.
    """
    coarse, fine = np.asarray(measured, dtype=float), np.asarray(halved, dtype=float)
    return np.where(np.isnan(coarse) == np.isnan(fine), _RICHARDSON * np.abs(coarse - fine), np.inf)


def relative(error: ArrayLike, measured: ArrayLike) -> Array:
    """The error as a fraction of the measure, arrays of one shape; NaN without a measure, 0 without an error.

    Of what is no more than rounding it is 0 too.
    """
    parts, whole = np.asarray(error, dtype=float), np.asarray(measured, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        small = (parts == 0) | ((np.abs(whole) < _ROUNDING) & (parts < _ROUNDING))
        return np.where(np.isnan(whole), np.nan, np.where(small, 0.0, parts / whole))


def error_of(measure: str) -> str:
    """The name of the error of `measure` in a Dataset."""
    return f"{measure}_step_error"


def about_error(measure: str) -> dict[str, str]:
    """The attributes of the error of `measure`."""
    return {
        "long_name": f"error of {measure} that the step makes, estimated",
        "comment": f"{_RICHARDSON:g} |{measure} at step h − {measure} at h/2|, Richardson's estimate for the order 1; "
        "inf: defined at one of both steps only",
        "units": "1",
    }
