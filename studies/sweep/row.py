"""The layout of one run's numbers: the one place that parts on disk and the Dataset take it from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.void]

# counts up when fields change or mean something else, so that parts of an older layout are not read
LAYOUT = 5


def row_of(observers: Sequence[str], quantities: Sequence[str], measures: Sequence[str]) -> np.dtype[np.void]:
    """The fields of a run, the same bytes on every machine.

    Each measure (observers × quantities); failed_at (observers) and plant_failed_at: the time of a failure or NaN;
    failure (observers) and plant_failure: what failed, as an index into `causes`.
    """
    each = (len(observers),)
    return np.dtype(
        [
            *((measure, "<f8", (*each, len(quantities))) for measure in measures),
            ("failed_at", "<f8", each),
            ("plant_failed_at", "<f8"),
            ("failure", "<i2", each),
            ("plant_failure", "<i2"),
        ]
    )
