"""The adaptive sliding mode observer."""

from typing import Any

import numpy as np

from .parameters import Parameters, column, gains


class AdaptiveSlidingMode:
    """The observer for one set of parameters."""

    def __init__(self, parameters: Parameters):
        p = self.p = gains(parameters, "adaptive_sliding_mode")
        self.eta, self.r0, self.eps, self.alpha, self.gam, self.dead = (
            column(p, n + "1", n + "2") for n in ("eta", "r0", "eps_a", "alpha_a", "gamma_a", "delta0")
        )

    def rates(self, X: Any, d: Any, o: int, e1: Any, e: Any, accel: Any, x2: Any) -> None:
        """Write the derivatives of its states, the rows of X from `o` on, into `d`."""
        p = self.p
        delta = p["delta_a"]
        l_a, r_0, k, r = X[25], X[26], X[27:31:2], X[28:31:2]
        # [La] L = l₀ + l_a,  L⁺ = max(L, L_min)
        L = p["l0"] + l_a
        L_p = np.maximum(L, p["L_min"])
        # [deltaa0] d₀ = L − |Δ̂|/(aβ₀) − ε_a0;  [dotla, rhoa0] l̇_a = −(r₀₀ + r_a0) sg(d₀)
        d_0 = L - abs(X[o + 2]) / (p["a_dual"] * p["beta0"]) - p["eps_a0"]
        dl = -(p["r00"] + r_0) * d_0 / (delta + abs(d_0))
        # [dra0] ṙ_a0 = γ_a0|d₀| if |d₀| > δ₀₀ else 0, − leak r_a0, r_a0 ≤ r_max
        dr_0 = np.where(abs(d_0) > p["delta00"], p["gamma_a0"] * abs(d_0), 0.0) - p["leak"] * r_0
        dr_0 = np.where((r_0 >= p["r_max"]) & (dr_0 > 0), 0.0, dr_0)
        # L ≤ L_min and l̇_a < 0: l̇_a = ṙ_a0 = 0
        held = (p["L_min"] >= L) & (dl < 0)
        dl, dr_0 = np.where(held, 0.0, dl), np.where(held, 0.0, dr_0)
        d[25], d[26] = dl, dr_0
        # α = α₀√L⁺, β = β₀L⁺, φ = −(L̇/L⁺) e₁
        s1 = e1 / (delta + abs(e1))
        beta_s = p["beta0"] * L_p * s1
        # [AO1a] x̂̇₁ = x̂₂ + α|e₁|^½ sg(e₁) − φ;  [AO1b] x̂̇₂ = (y₃ − y₂)/m + β sg(e₁);  [AO1c] τ_a Δ̂̇ = −Δ̂ + β sg(e₁)
        d[o] = X[o + 1] + p["alpha0"] * np.sqrt(L_p * abs(e1)) * s1 + dl / L_p * e1
        d[o + 1] = accel + beta_s
        d[o + 2] = (-X[o + 2] + beta_s) / p["tau_a"]
        # [AO2a, AO3a] x̂̇_{j+2} = ±x̂₂ + (k_j + η_j) sg(e_{j+2});  [AO2b, AO3b] τ_a û̇_j = −û_j + (k_j + η_j) sg(e_{j+2})
        v = (k + self.eta) * e / (delta + abs(e))
        d[o + 3 : o + 7 : 2] = x2 + v
        d[o + 4 : o + 7 : 2] = (-X[o + 4 : o + 7 : 2] + v) / p["tau_a"]
        # d_j = k_j − |û_j|/α_aj − ε_aj;  [kj, rhoaj] k̇_j = −(r₀j + r_aj) sg(d_j)
        d_j = k - abs(X[o + 4 : o + 7 : 2]) / self.alpha - self.eps
        dk = -(self.r0 + r) * d_j / (delta + abs(d_j))
        # [draj] ṙ_aj = γ_aj|d_j| if |d_j| > δ₀j else 0, − leak r_aj, r_aj ≤ r_max
        dr = np.where(abs(d_j) > self.dead, self.gam * abs(d_j), 0.0) - p["leak"] * r
        dr = np.where((r >= p["r_max"]) & (dr > 0), 0.0, dr)
        # k_j at 0 or k_max and moving out: k̇_j = ṙ_aj = 0
        held = ((k <= 0) & (dk < 0)) | ((k >= p["k_max"]) & (dk > 0))
        d[27:31:2], d[28:31:2] = np.where(held, 0.0, dk), np.where(held, 0.0, dr)
