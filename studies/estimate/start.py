"""Where the estimates of a recording start."""

from __future__ import annotations

from collections.abc import Sequence

from ...model.symbols import hat
from ...model.system import System


def at_rest(system: System, first: Sequence[float]) -> dict[str, float]:
    """x̂(0) of positions and tendon lengths (joints + muscles, dimensionless), by the observers' names for it."""
    known = dict(zip((*system.joint("q"), *system.muscle("L_S")), first, strict=True))
    known |= dict.fromkeys(system.joint("dq"), 0.0)
    return {f"initial.{hat(name)}": float(value) for name, value in known.items()}
