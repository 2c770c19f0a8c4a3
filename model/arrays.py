"""The one array type of numbers, and what counts as a number."""

from __future__ import annotations

from numbers import Real
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def is_number(value: object) -> TypeGuard[Real]:
    """Whether it is a real number of Python or NumPy: no text, truth value, time or complex number."""
    # a timedelta64 is an integer to NumPy
    return isinstance(value, Real) and not isinstance(value, bool | np.timedelta64)
