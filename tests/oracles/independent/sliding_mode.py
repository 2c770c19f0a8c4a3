"""The sliding mode observer."""

from typing import Any

import numpy as np

from .parameters import Parameters, column, gains


class SlidingMode:
    """The observer for one set of parameters."""

    def __init__(self, parameters: Parameters):
        p = self.p = gains(parameters, "sliding_mode")
        self.alpha_23 = column(p, "alpha2", "alpha3")

    def rates(self, X: Any, d: Any, o: int, e1: Any, e: Any, accel: Any, x2: Any) -> None:
        """Write the derivatives of its states, the rows of X from `o` on, into `d`."""
        p = self.p
        # [v11, v12, v2, v3] v₁₁ = λ₁₁|e₁|^½ sg(e₁), v₁₂ = α₁₁ sg(e₁), v₂ = α₂ sg(e₃), v₃ = α₃ sg(e₄)
        s1, v = e1 / (p["delta_s"] + abs(e1)), self.alpha_23 * e / (p["delta_s"] + abs(e))
        v12 = p["alpha11"] * s1
        # [SO1a] x̂̇₁ = x̂₂ + v₁₁;  [SO1b] x̂̇₂ = (y₃ − y₂)/m + v₁₂;  [SO1c] τ_s Δ̂̇ = −Δ̂ + v₁₂
        d[o] = X[o + 1] + p["lambda11"] * np.sqrt(abs(e1)) * s1
        d[o + 1] = accel + v12
        d[o + 2] = (-X[o + 2] + v12) / p["tau_s"]
        # [SO2a, SO3a] x̂̇_{j+2} = ±x̂₂ + v_{j+1};  [SO2b, SO3b] τ_s û̇_j = −û_j + v_{j+1}
        d[o + 3 : o + 7 : 2] = x2 + v
        d[o + 4 : o + 7 : 2] = (-X[o + 4 : o + 7 : 2] + v) / p["tau_s"]
