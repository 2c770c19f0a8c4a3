"""The closed loop: plant, controller and observers as one right-hand side of 31 states."""

from typing import Any

import numpy as np

from .adaptive_sliding_mode import AdaptiveSlidingMode
from .controller import Backstepping
from .high_gain import HighGain
from .muscle import Curves, Phi_P, Phi_S, Phi_S_inv, curves_of, f, fibres, g_inv
from .parameters import Parameters, value
from .signals import Signal, sine_activations, sine_reference, sine_uncertainty
from .sliding_mode import SlidingMode
from .states import OBSERVERS, Array


class Model:
    """The equations for one set of parameters; `rhs` is the derivative of all 31 states."""

    def __init__(
        self,
        parameters: Parameters,
        reference: Signal | None = None,
        uncertainty: Signal | None = None,
        activations: Signal | None = None,
    ):
        p = self.p = dict(parameters)
        self.uncertainty = uncertainty or sine_uncertainty(p)
        self.activations = activations or sine_activations(p)
        consumers = ("plant", *OBSERVERS)
        self.m = {c: value(p, "plant.m", c) for c in consumers}
        self.C = {c: value(p, "plant.C", c) for c in consumers}
        self.curves = {c: curves_of(p, c) for c in consumers}
        self.same = {  # observers whose tendon curves are the plant's: one inversion serves all
            c: all(np.array_equal(getattr(self.curves[c], n), getattr(self.curves["plant"], n)) for n in vars(Curves()))
            for c in consumers
        }
        self.drive = value(p, "plant.drive")
        self.a_min = value(p, "plant.a_min")
        self.controller = Backstepping(p, reference or sine_reference(p), self.uncertainty)
        self.observers = {
            "high_gain": HighGain(p),
            "sliding_mode": SlidingMode(p),
            "adaptive_sliding_mode": AdaptiveSlidingMode(p),
        }

    def start(self) -> Array:
        """The 31 states at τ = 0."""
        hat = [value(self.p, f"initial.x{i}_hat") for i in (1, 2, 3, 4)]
        observer = [hat[0], hat[1], 0.0, hat[2], 0.0, hat[3], 0.0]
        return np.array([*(value(self.p, f"initial.x{i}") for i in (1, 2, 3, 4)), *observer * 3, 0, 0, 0.2, 0, 0.2, 0])

    def drives(self, t: Any, x: Any, pulse: Any = 0.0) -> tuple[Array, Array, Array]:
        """u of the plant with the pulse on u₁; the activation put in, NaN for the virtual drive; the limits' flags."""
        if self.drive == "virtual":
            u = self.controller.inputs(t, x)
            a, flags = np.full(np.shape(x[2:4]), np.nan), np.zeros((4, *x[2:4].shape), bool)
        else:
            if self.drive == "requested":
                unlimited = self.controller.activations(t, x)
            else:
                unlimited = np.stack(np.broadcast_arrays(*self.activations(t), x[0])[:2])
            # a_j ∈ [a_min, 1]
            a = np.clip(unlimited, self.a_min, 1.0)
            c, L_C = self.curves["plant"], fibres(x[0], x[2:4], self.C["plant"])
            # [z] z_j = (Φ_S(x_{j+2}) − Φ_P(L_Cj))/(a_j f(L_Cj)) ∈ [0, 1.45],   u_j = g⁻¹(z_j)
            z = (Phi_S(x[2:4], c) - Phi_P(L_C)) / (a * f(L_C, c))
            flags = np.stack([unlimited < self.a_min, unlimited > 1.0, z < 0.0, z > 1.45])
            u = g_inv(np.clip(z, 0.0, 1.45), c)
        u[0] += pulse
        return u, a, flags

    def rhs(self, t: float, X: Any, noise: Any = 0.0, pulse: Any = 0.0) -> Array:
        """Ẋ for X of shape (31, n), the held noise (3, n) and the held pulse."""
        d = np.empty_like(X)
        m, c = self.m["plant"], self.curves["plant"]
        x2, x34 = X[1], X[2:4]
        sign = np.array([[1.0], [-1.0]])
        F = Phi_S(x34, c)
        u, _, _ = self.drives(t, X[:4], pulse)
        # [load1] ẋ₁ = x₂;  [load2] ẋ₂ = (Φ_S(x₄) − Φ_S(x₃))/m + Δ_Φ;  [lsdot1] ẋ₃ = x₂ + u₁;  [lsdot2] ẋ₄ = −x₂ + u₂
        d[0] = x2
        d[1] = (F[1] - F[0]) / m + self.uncertainty(t)[0]
        d[2:4] = sign * x2 + u

        # [y1] y₁ = x₁ + ν₁;  [y2, y3] y₂ = Φ_S(x₃) + ν₂, y₃ = Φ_S(x₄) + ν₃
        y = np.concatenate([X[:1], F]) + noise
        common = Phi_S_inv(y[1:], c)
        for i, name in enumerate(OBSERVERS):
            o = 4 + 7 * i
            # e₁ = y₁ − x̂₁, e₃ = Φ_S⁻¹(y₂) − x̂₃, e₄ = Φ_S⁻¹(y₃) − x̂₄
            e1 = y[0] - X[o]
            e = (common if self.same[name] else Phi_S_inv(y[1:], self.curves[name])) - X[o + 3 : o + 7 : 2]
            accel = (y[2] - y[1]) / self.m[name]
            self.observers[name].rates(X, d, o, e1, e, accel, sign * X[o + 1])
        return d
