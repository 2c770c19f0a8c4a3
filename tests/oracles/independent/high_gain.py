"""The high-gain observer."""

from typing import Any

from .parameters import Parameters, column, gains


class HighGain:
    """The observer for one set of parameters."""

    def __init__(self, parameters: Parameters):
        p = self.p = gains(parameters, "high_gain")
        self.h_1, self.h_2 = column(p, "h21", "h31"), column(p, "h22", "h32")

    def rates(self, X: Any, d: Any, o: int, e1: Any, e: Any, accel: Any, x2: Any) -> None:
        """Write the derivatives of its states, the rows of X from `o` on, into `d`."""
        p, h = self.p, self.p["eps_h"]
        # [HO1a] x̂̇₁ = x̂₂ + h₁₁/ε e₁;  [HO1b] x̂̇₂ = (y₃ − y₂)/m + Δ̂ + h₁₂/ε² e₁;  [HO1c] Δ̂̇ = h₁₃/ε³ e₁
        d[o] = X[o + 1] + p["h11"] / h * e1
        d[o + 1] = accel + X[o + 2] + p["h12"] / h**2 * e1
        d[o + 2] = p["h13"] / h**3 * e1
        # [HO2a, HO3a] x̂̇_{j+2} = ±x̂₂ + û_j + h_{j+1,1}/ε e_{j+2};  [HO2b, HO3b] û̇_j = h_{j+1,2}/ε² e_{j+2}
        d[o + 3 : o + 7 : 2] = x2 + X[o + 4 : o + 7 : 2] + self.h_1 / h * e
        d[o + 4 : o + 7 : 2] = self.h_2 / h**2 * e
