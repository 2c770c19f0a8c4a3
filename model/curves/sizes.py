"""The sizes of a muscle, and how they look in those of another."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

import casadi as ca

# as curve sets that have sizes call them
SIZES = ("L_slack", "F_max", "l_opt", "v_max")

# expressions or numbers
Q = TypeVar("Q", ca.SX, float)


def relative(sizes: Mapping[str, Q], reference: Mapping[str, Q]) -> dict[str, Q]:
    """The SIZES of a muscle in those of a reference: both lengths in its l_opt."""
    # L_slack/l₀,  F_max/F₀,  l_opt/l₀,  v_max/v₀
    units = {"L_slack": "l_opt", "F_max": "F_max", "l_opt": "l_opt", "v_max": "v_max"}
    return {size: sizes[size] / reference[unit] for size, unit in units.items()}
