"""What must hold between several numbers, beside what each may be alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any


@dataclass(frozen=True)
class Below:
    """One thing must be below another; both in words, and as they follow from numbers.

    because: what else would be, or what the second one is. sides: both, of numbers or of expressions by name.
    """

    left: str
    right: str
    because: str
    sides: Callable[[Any], tuple[Any, Any]]

    def objection(self, values: Mapping[str, float]) -> str:
        """What does not hold with these numbers, or an empty string."""
        # plain numbers: a sweep asks for thousands of combinations
        left, right = self.sides(SimpleNamespace(**values))
        if left < right:
            return ""
        return f"{self.left} = {left:.6g} must be below {self.right} = {right:.6g}, {self.because}"
