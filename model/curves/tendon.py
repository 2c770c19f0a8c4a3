"""The tendon of one muscle in numbers: its force, its length, where its regions meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ..arrays import Array
from ..block import Symbols
from . import Curve, Curves, CurveSet, by_muscle


@dataclass(frozen=True)
class Tendon:
    """A curve set with the numbers of one tendon."""

    curves: CurveSet
    numbers: Mapping[str, float]

    def force(self, length: Array) -> Array:
        """Φ_S at each length."""
        return self._at(self.curves.Phi_S, length)

    def slope(self, length: Array) -> Array:
        """Φ′_S at each length."""
        return self._at(self.curves.Phi_S_prime, length)

    def length(self, force: Array) -> Array:
        """Φ_S⁻¹ at each force."""
        return self._at(self.curves.Phi_S_inv, force)

    @property
    def toe_force(self) -> float:
        """The force at which the toe ends."""
        return float(ca.DM(ca.SX(self.curves.toe_force(self._symbols))))

    @property
    def edges(self) -> tuple[float, float]:
        """The slack length, and where the toe ends."""
        return self.numbers["L_slack"], float(self.length(np.array([self.toe_force]))[0])

    @property
    def _symbols(self) -> Symbols:
        return Symbols({key: ca.SX(value) for key, value in self.numbers.items()})

    def _at(self, curve: Curve, values: Array) -> Array:
        x = ca.SX.sym("x")
        return np.array(ca.Function("curve", [x], [curve(x, self._symbols)])(ca.DM(values).T), dtype=float).ravel()


def tendon(curves: Curves, muscle: str, numbers: Mapping[str, float]) -> Tendon:
    """The tendon of a muscle; `numbers` has the paths `muscle1.L_slack`, …."""
    own = by_muscle(curves)[muscle]
    return Tendon(own, {key: numbers[f"{muscle}.{key}"] for key in own.tendon})
