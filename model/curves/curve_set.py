"""A CurveSet is what a publication says about one muscle: its curves, their numbers, and what follows from both."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ..arrays import Array
from ..block import Parameters, Symbols
from ..dialect import clamp, outside
from ..rules import Below
from ..symbols import MUSCLES

Curve = Callable[[ca.SX, Symbols], ca.SX]
# a number that follows from the parameters
Number = Callable[[Symbols], ca.SX | float]
# values at neighbouring arguments, and 1 where they may be wrong
Neighbours = Callable[[Sequence[ca.SX], Symbols], tuple[list[ca.SX], ca.SX]]

# keeps 0/0 out of the activation where the fibre is far from its optimal length
_FORCE_FLOOR = 1e-12


@dataclass(frozen=True, eq=False)  # compared by identity: SX has no usable ==
class CurveSet:
    """The characteristic curves of a muscle, each a function of (argument, parameters), in the units of the pair."""

    name: str
    sentence: str
    source: str
    tendon: Parameters
    fibre: Parameters
    Phi_S: Curve  # tendon force over tendon length
    Phi_S_inv: Curve  # tendon length over tendon force
    Phi_P: Curve  # parallel elastic force over fibre length
    f: Curve  # isometric force at full activation over fibre length
    g: Curve  # force factor over shortening velocity
    g_inv: Curve  # shortening velocity over force factor
    toe_force: Number  # tendon force from which on the tendon is straight, or looks so
    Phi_S_inv_near: Neighbours | None = None  # Φ_S⁻¹ of forces that are close together, for less
    speed: Number = lambda p: 1.0  # largest shortening velocity
    damping: Number | None = None  # b of the force −b u that acts beside Φ_P
    g_inv_damped: Callable[[ca.SX, ca.SX, Symbols], ca.SX] | None = None  # the u with g(u) − βu = z, over (z, β)
    tables: Mapping[str, Sequence[tuple[float, float]]] | None = None  # the points of curves that a user gave as tables
    rises: Below | None = None  # what a tendon's numbers must fulfil for its curve to rise

    def __repr__(self) -> str:
        """Its name: functions have no words of their own."""
        return f"CurveSet({self.name})"

    @property
    def parameters(self) -> Parameters:
        """All numbers of the curves: the tendon's, then the fibre's."""
        return {**self.tendon, **self.fibre}

    def objection(self, tendon: Mapping[str, float]) -> str:
        """Why a tendon's numbers make no curve that rises, or an empty string."""
        return self.rises.objection(tendon) if self.rises else ""

    def activation(self, F: ca.SX, L_C: ca.SX, u: ca.SX, p: Symbols) -> ca.SX:
        """The activation of a muscle with tendon force F and fibre length L_C that shortens with velocity u."""
        passive = self.Phi_P(L_C, p)
        if self.damping is not None:
            passive = passive - self.damping(p) * u
        return self.activation_of(F - passive, ca.fmax(self.f(L_C, p), _FORCE_FLOOR), u, p)

    def activation_of(self, active: ca.SX, f: ca.SX, u: ca.SX, p: Symbols) -> ca.SX:
        """The activation that gives the force `active` at isometric force f and velocity u."""
        # a = (Φ_S − Φ_P)/(g(u) f)   [z]
        return active / (self.g(u, p) * f)

    def force(self, L_C: ca.SX, a: ca.SX, u: ca.SX, p: Symbols) -> ca.SX:
        """The force along fibres of length L_C and activation a that shorten with velocity u."""
        active = a * ca.fmax(self.f(L_C, p), _FORCE_FLOOR) * self.g(u / self.slowing(a, p), p)
        # Φ_S = Φ_P + a f g(u/S) − b u
        return self.Phi_P(L_C, p) + active - (0 if self.damping is None else self.damping(p) * u)

    def velocity(self, F: ca.SX, L_C: ca.SX, a: ca.SX, p: Symbols, z_max: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The shortening velocity u of a muscle of activation a, and 1 where g(u/S) is at a limit, 0 or z_max."""
        isometric = a * ca.fmax(self.f(L_C, p), _FORCE_FLOOR)
        # z = (Φ_S − Φ_P)/(a f)   [z]
        z = (F - self.Phi_P(L_C, p)) / isometric
        slowing = self.slowing(a, p)
        if self.damping is None or self.g_inv_damped is None:
            # u = g⁻¹(z)   [gj]
            return slowing * self.g_inv(clamp(z, 0, z_max), p), outside(z, 0, z_max)
        # a f g(u/S) − b u = Φ_S − Φ_P, over a f
        drag = slowing * self.damping(p) / isometric
        # g is 0 at the largest velocity
        low, high = -drag * self.speed(p), z_max - drag * self.g_inv(z_max, p)
        return slowing * self.g_inv_damped(clamp(z, low, high), drag, p), outside(z, low, high)

    def slowing(self, a: ca.SX, p: Symbols) -> ca.SX | float:
        """S(a): the part of its largest velocity that a muscle of activation a reaches, u = S(a) g⁻¹(z)."""
        return 1.0

    def Phi_S_prime(self, L: ca.SX, p: Symbols) -> ca.SX:
        """Φ′_S, by CasADi."""
        s = ca.SX.sym("L")
        return ca.substitute(ca.jacobian(self.Phi_S(s, p), s), s, L)


def sampled(curve: Curve, numbers: Mapping[str, float], x: Array) -> Array:
    """The curve (n) at the arguments x (n), with a number for each parameter."""
    s, p = ca.SX.sym("x"), Symbols({name: ca.SX(number) for name, number in numbers.items()})
    return np.array(ca.Function("curve", [s], [curve(s, p)])(ca.DM(x).T), dtype=float).ravel()


# one set for both muscles, or one for each
Curves = CurveSet | tuple[CurveSet, CurveSet]


def by_muscle(curves: Curves) -> dict[str, CurveSet]:
    """The set of each muscle, by its name."""
    return dict(zip(MUSCLES, (curves, curves) if isinstance(curves, CurveSet) else curves, strict=True))
