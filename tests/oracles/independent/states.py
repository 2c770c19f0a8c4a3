"""What is computed, by name: the 31 states, the estimated quantities, and the axes they lie on.

Arrays carry the muscles (2) or the states (31) on the first axis and any number of runs or time points behind it.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

OBSERVERS = ("high_gain", "sliding_mode", "adaptive_sliding_mode")
QUANTITIES = ("x1", "x2", "x3", "x4", "Delta", "u1", "u2", "a1", "a2")
ADAPTIVE = ("l_a", "r_a0", "k_1", "r_a1", "k_2", "r_a2")
STATES = (
    "x1", "x2", "x3", "x4",
    *(f"{o}.{s}_hat" for o in OBSERVERS for s in ("x1", "x2", "Delta", "x3", "u1", "x4", "u2")),
    *(f"adaptive_sliding_mode.{s}" for s in ADAPTIVE),
)  # fmt: skip
