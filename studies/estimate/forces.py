"""Forces that are too small for their muscle."""

from __future__ import annotations

# forces below this part of F_max are no forces of a muscle that works, or not in newtons
_LEAST = 0.005


def weak(name: str, largest: float) -> str:
    """What to say of a force that is never above so much of F_max; nothing if that is enough."""
    if largest >= _LEAST:
        return ""
    return f"{name} is never above {largest:.2g} F_max of its muscle: it may be in kN, or F_max is another"
