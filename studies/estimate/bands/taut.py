"""When a tendon's length can be known: while its force is above what noise may feign."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....model.arrays import Array

# standard deviations of its noise that a force must pass
_SIGMAS = 5.0


def still_taut(before: bool, force: float, sigma: float) -> bool:
    """Whether it can be known at a sample, by whether it could be at the one before."""
    return force > 0 and (before or force > _SIGMAS * sigma)


def taut(force: Array, sigma: float) -> NDArray[np.bool_]:
    """False from a sample (n) without force on until the force has passed five sigma of its noise; so at the start."""
    passed, slack = force > _SIGMAS * sigma, force <= 0
    n = np.arange(len(force))
    # which of both came last
    last = [np.maximum.accumulate(np.where(event, n, -1)) for event in (passed, slack)]
    return np.asarray(last[0] > last[1])
