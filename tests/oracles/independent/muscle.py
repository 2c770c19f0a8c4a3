"""The curves of both muscles, their inverses, and the activation that follows from them."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .parameters import Parameters, value


@dataclass(frozen=True)
class Curves:
    """Constants of one muscle, or of both as columns of shape (2, 1)."""

    W: Any = 0.3
    A_hill: Any = 0.25
    g_max: Any = 1.5
    L_slack: Any = 2.0
    toe: Any = 0.04
    F_toe: Any = 0.5
    k: Any = 19.2308

    @cached_property
    def quintic(self) -> tuple[Any, Any, Any]:
        F, D = self.F_toe, self.toe * self.k
        return 10 * F - 4 * D, -15 * F + 7 * D, 6 * F - 3 * D


def curves_of(p: Parameters, consumer: str) -> Curves:
    """Both muscles' curves as this consumer sees them."""
    return Curves(
        **{
            name: np.array([[value(p, f"muscle{j}.{name}", consumer)] for j in (1, 2)])
            for name in ("W", "A_hill", "g_max", "L_slack", "toe", "F_toe", "k")
        }
    )


def Phi_S(L: Any, c: Curves = Curves()) -> Any:
    A3, A4, A5 = c.quintic
    s = (np.asarray(L, float) - c.L_slack) / c.toe
    # [PhiSj] Φ_S = 0 | s³(A₃ + s(A₄ + s A₅)) | F + k (L − L_slack − toe)
    return np.where(s < 0, 0.0, np.where(s < 1, s**3 * (A3 + s * (A4 + s * A5)), c.F_toe + c.k * c.toe * (s - 1)))


def dPhi_S(L: Any, c: Curves = Curves()) -> Any:
    A3, A4, A5 = c.quintic
    s = (np.asarray(L, float) - c.L_slack) / c.toe
    # Φ′_S = 0 | s²(3A₃ + s(4A₄ + 5s A₅))/toe | k
    return np.where(s < 0, 0.0, np.where(s < 1, s**2 * (3 * A3 + s * (4 * A4 + s * 5 * A5)) / c.toe, c.k))


def Phi_S_inv(y: Any, c: Curves = Curves()) -> Any:
    """Newton's method in s to the last bit; where it does not settle (unusual constants), bisection."""
    y = np.asarray(y, float)
    A3, A4, A5 = c.quintic
    B3, B4, B5 = 3 * A3, 4 * A4, 5 * A5
    inside = np.minimum(np.maximum(y, 1e-300), c.F_toe)
    s = np.minimum(np.maximum(np.cbrt(inside / A3), 1e-100), 1.0)
    with np.errstate(all="ignore"):
        for _ in range(12):
            # F(s) = s³(A₃ + s(A₄ + s A₅)) − y = 0,   s ← s − F/F′
            step = (s * (A3 + s * (A4 + s * A5)) - inside / (s * s)) / (B3 + s * (B4 + s * B5))
            s = s - step
            if abs(step).max() < 1e-15:
                break
        else:
            low, high = np.zeros_like(s), np.ones_like(s)
            for _ in range(60):
                s = (low + high) / 2
                below = s**3 * (A3 + s * (A4 + s * A5)) < inside
                low, high = np.where(below, s, low), np.where(below, high, s)
    # Φ_S⁻¹: y ≤ 0 → L_slack;  0 < y < F → the root;  y ≥ F → linear
    linear = c.L_slack + c.toe + (y - c.F_toe) / c.k
    return np.where(y <= 0, c.L_slack, np.where(y < c.F_toe, c.L_slack + c.toe * s, linear))


def Phi_P(L_C: Any) -> Any:
    # [PhiPj] Φ_P = 8 max(L_C − 1, 0)³
    return 8 * np.maximum(np.asarray(L_C, float) - 1, 0) ** 3


def f(L_C: Any, c: Curves = Curves()) -> Any:
    # [fj] f = exp(−((L_C − 1)/W)²)
    return np.exp(-(((np.asarray(L_C, float) - 1) / c.W) ** 2))


def g_inv(z: Any, c: Curves = Curves()) -> Any:
    z = np.asarray(z, float)
    A, G = c.A_hill, c.g_max
    with np.errstate(divide="ignore", invalid="ignore"):
        # [gj] z ≤ 1: (1 − z)/(1 + z/A);  z > 1: −A(z − 1)(g_max − 1)/((A + 1)(g_max − z))
        return np.where(z <= 1, (1 - z) / (1 + z / A), -A * (z - 1) * (G - 1) / ((A + 1) * (G - z)))


def g(u: Any, c: Curves = Curves()) -> Any:
    u = np.asarray(u, float)
    A, G, v = c.A_hill, c.g_max, -u
    with np.errstate(divide="ignore", invalid="ignore"):
        # [gj]⁻¹ u ≥ 0: (1 − u)/(1 + u/A);  v = −u > 0: (v(A+1)g_max + A(g_max−1))/(A(g_max−1) + v(A+1))
        return np.where(u >= 0, (1 - u) / (1 + u / A), (v * (A + 1) * G + A * (G - 1)) / (A * (G - 1) + v * (A + 1)))


def fibres(x1: Any, x34: Any, C: float) -> Any:
    # L_C1 = x₁ − x₃, L_C2 = C − x₁ − x₄
    return np.stack([x1, C - x1]) - x34


def activation(x1: Any, x34: Any, u: Any, C: float, c: Curves) -> Any:
    L_C = fibres(x1, x34, C)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # [z] a_j = (Φ_S(x_{j+2}) − Φ_P(L_Cj))/(g(u_j) f(L_Cj))
        return (Phi_S(x34, c) - Phi_P(L_C)) / (g(u, c) * f(L_C, c))
