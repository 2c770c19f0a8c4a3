"""What must hold between several numbers, beside what each may be alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca

from .block import Symbols


@dataclass(frozen=True)
class Below:
    """One thing must be below another; both in words, and as they follow from numbers.

    because: what else would be, or what the second one is.
    """

    left: str
    right: str
    because: str
    sides: Callable[[Symbols], tuple[ca.SX, ca.SX]]

    def objection(self, values: Mapping[str, float]) -> str:
        """What does not hold with these numbers, or an empty string."""
        left, right = map(float, self.sides(Symbols({name: ca.SX(value) for name, value in values.items()})))
        if left < right:
            return ""
        return f"{self.left} = {left:.6g} must be below {self.right} = {right:.6g}, {self.because}"
