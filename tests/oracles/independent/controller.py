"""The backstepping controller with pretension, and its gains."""

from typing import Any

import numpy as np

from .muscle import Phi_S, activation, curves_of, dPhi_S
from .parameters import Parameters, value
from .signals import Signal
from .states import Array


def lqr(m: float, q: float, R: float) -> tuple[Array, Array]:
    """K and P of the double integrator with B = (0, 1/m), Q = q I."""
    # p₁₂ = m√(qR), p₂₂ = m√(R(q + 2p₁₂)), p₁₁ = p₁₂p₂₂/(m²R), K = (p₁₂, p₂₂)/(mR)
    p12 = m * np.sqrt(q * R)
    p22 = m * np.sqrt(R * (q + 2 * p12))
    return np.array([p12, p22]) / (m * R), np.array([[p12 * p22 / (m**2 * R), p12], [p12, p22]])


class Backstepping:
    """The controller for one set of parameters."""

    def __init__(self, p: Parameters, reference: Signal, uncertainty: Signal):
        self.reference, self.uncertainty = reference, uncertainty
        self.m, self.C = (value(p, f"plant.{n}", "controller") for n in ("m", "C"))
        self.curves = curves_of(p, "controller")
        self.gamma, self.k_c, self.F_c, self.u_max, self.Delta_min = (
            value(p, f"controller.{n}") for n in ("gamma", "k_c", "F_c", "u_max", "Delta_min")
        )
        self.K, self.P = lqr(self.m, value(p, "controller.q"), value(p, "controller.R"))

    def inputs(self, t: Any, x: Any) -> Array:
        """u₁ and u₂ from the true states of the plant."""
        m, c, K = self.m, self.curves, self.K
        r, dr, ddr, dddr = self.reference(t)
        D, dD = self.uncertainty(t)
        F, dF = Phi_S(x[2:4], c), dPhi_S(x[2:4], c)
        # e = (x₁ − r, x₂ − ṙ),   ζ = Φ_S(x₄) − Φ_S(x₃) + mΔ_Φ − m r̈
        e1, e2 = x[0] - r, x[1] - dr
        zeta = F[1] - F[0] + m * D - m * ddr
        # K₁ = γ + KB,   K₂ = KA + γK + BᵀP
        K1 = self.gamma + K[1] / m
        K2 = np.array([0.0, K[0]]) + self.gamma * K + self.P[1] / m
        # [beta] β = −K₁ζ − K₂e + (Φ′_S1 + Φ′_S2) x₂ − mΔ̇_Φ + m r‴
        beta = -K1 * zeta - K2[0] * e1 - K2[1] * e2 + (dF[0] + dF[1]) * x[1] - m * dD + m * dddr
        # Δ = max(Φ′²_S1 + Φ′²_S2, Δ_min)
        det = np.maximum(dF[0] ** 2 + dF[1] ** 2, self.Delta_min)
        # u₁ = −Φ′_S1 β/Δ,   u₂ = Φ′_S2 β/Δ
        u = np.stack([-dF[0] * beta / det, dF[1] * beta / det])
        # u += k_c (F_c − (Φ_S1 + Φ_S2)/2)/Δ · (Φ′_S2, Φ′_S1)
        u = u + self.k_c * (self.F_c - (F[0] + F[1]) / 2) / det * dF[::-1]
        # |u_j| ≤ u_max
        return np.clip(u, -self.u_max, self.u_max)

    def activations(self, t: Any, x: Any) -> Any:
        """The activations that give these inputs, before any limit."""
        return activation(x[0], x[2:4], self.inputs(t, x), self.C, self.curves)
