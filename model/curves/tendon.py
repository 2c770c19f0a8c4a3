"""The tendon of one muscle in numbers: its force, its length, where its regions meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ..arrays import Array
from ..block import Symbols
from . import CurveSet, sampled


@dataclass(frozen=True)
class Tendon:
    """A curve set with the numbers of one tendon; lengths and forces (n) are in the units of the pair."""

    curves: CurveSet
    numbers: Mapping[str, float]

    def force(self, length: Array) -> Array:
        """Φ_S at each length."""
        return sampled(self.curves.Phi_S, self.numbers, length)

    def slope(self, length: Array) -> Array:
        """Φ′_S at each length."""
        return sampled(self.curves.Phi_S_prime, self.numbers, length)

    def length(self, force: Array) -> Array:
        """Φ_S⁻¹ at each force."""
        return sampled(self.curves.Phi_S_inv, self.numbers, force)

    @property
    def toe_force(self) -> float:
        """The force at which the toe ends."""
        p = Symbols({name: ca.SX(number) for name, number in self.numbers.items()})
        return float(ca.DM(ca.SX(self.curves.toe_force(p))))

    @property
    def edges(self) -> tuple[float, float]:
        """The slack length, and where the toe ends."""
        return self.numbers["L_slack"], float(self.length(np.array([self.toe_force]))[0])


def tendon(curve_set: CurveSet, muscle: str, numbers: Mapping[str, float]) -> Tendon:
    """The tendon of a muscle with these curves; `numbers` has the paths `muscle1.L_slack`, …."""
    return Tendon(curve_set, {key: numbers[f"{muscle}.{key}"] for key in curve_set.tendon})
