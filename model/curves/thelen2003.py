"""The curves of Thelen, whose force-velocity relation depends on the activation, with OpenSim's numbers.

Thelen, Adjustment of muscle mechanics model parameters to simulate dynamic contractions in older adults, Journal of
Biomechanical Engineering 125, 2003; numbers, and straight lines where the hyperbolas end, as in OpenSim 4.6.
"""

from __future__ import annotations

import math

import casadi as ca

from ..block import Symbols
from ..dialect import clamp
from .curve_set import CurveSet
from .normalised import fibre_numbers, normalised, tendon_numbers

_SOURCE = "OpenSim 4.6, Thelen2003Muscle"

# tendon: force at the end of the toe, shape of the toe
_F_TOE, _K_TOE = 0.33, 3.0
# shape of the passive force, and of the force-length factor
_K_PE, _GAMMA = 4.0, 0.45
# force-velocity: Hill's constant, largest factor, the part of it at which the straight line begins
_A_F, _F_LEN, _THRESHOLD = 0.25, 1.4, 0.95
# velocity of a muscle of activation 0, in that of a fully active one
_S_0 = 0.25

# lengthening: v = (z − 1)E/(K(F_len − z))
_E, _K = _F_LEN - 1, 2 + 2 / _A_F
# z, v and dz/dv where the straight line begins
_Z_T = _THRESHOLD * _F_LEN
_V_T = (_Z_T - 1) * _E / (_K * (_F_LEN - _Z_T))
_SLOPE_T = _K * _E**2 / (_K * _V_T + _E) ** 2
# dz/dv at the largest shortening velocity
_SLOPE_0 = 1 / (1 + 1 / _A_F)
# keeps 0/0 out of the root for a fibre without force at its largest velocity
_TINY = 1e-300


def _toe(p: Symbols) -> tuple[ca.SX, ca.SX]:
    """Strain at the end of the toe, stiffness beyond: the slopes of both agree there, and fT(1 + strain) = 1."""
    # ε_toe = F_toe k eᵏ ε₀/((1 − F_toe)(eᵏ − 1) + F_toe k eᵏ)
    rise = _F_TOE * _K_TOE * math.exp(_K_TOE)
    toe = p.tendon_strain * rise / ((1 - _F_TOE) * math.expm1(_K_TOE) + rise)
    return toe, (1 - _F_TOE) / (p.tendon_strain - toe)


def _fT(length: ca.SX, p: Symbols) -> ca.SX:
    toe, k = _toe(p)
    strain = clamp(length - 1, 0, toe)
    # fT = F_toe(exp(k_toe ε/ε_toe) − 1)/(exp(k_toe) − 1), then straight
    return _F_TOE * ca.expm1(_K_TOE * strain / toe) / math.expm1(_K_TOE) + k * ca.fmax(length - 1 - toe, 0)


def _fT_inv(force: ca.SX, p: Symbols) -> ca.SX:
    toe, k = _toe(p)
    inside = clamp(force, 0, _F_TOE)
    # ε = ε_toe log(1 + fT(exp(k_toe) − 1)/F_toe)/k_toe, then straight
    return 1 + toe * ca.log1p(inside * math.expm1(_K_TOE) / _F_TOE) / _K_TOE + ca.fmax(force - _F_TOE, 0) / k


def _fP(length: ca.SX, p: Symbols) -> ca.SX:
    # fP = (exp(kPE(l − 1)/ε₀) − 1)/(exp(kPE) − 1), 0 below the optimal length
    return ca.expm1(_K_PE * ca.fmax(length - 1, 0) / p.passive_strain) / math.expm1(_K_PE)


def _fL(length: ca.SX, p: Symbols) -> ca.SX:
    # fL = exp(−(l − 1)²/γ)
    return ca.exp(-((length - 1) ** 2) / _GAMMA)


def _fV(v: ca.SX, p: Symbols) -> ca.SX:
    """The force factor of a fully active muscle; S(a) scales the velocity of others."""
    short, long = clamp(v, -1, 0), clamp(v, 0, _V_T)
    # v ≤ 0: (1 + v)/(1 − v/A_f);  v > 0: (K F_len v + E)/(K v + E); the other factor is 1, and the lines are 0
    hyperbolas = (1 + short) / (1 - short / _A_F) * (_K * _F_LEN * long + _E) / (_K * long + _E)
    return hyperbolas + _SLOPE_0 * ca.fmin(v + 1, 0) + _SLOPE_T * ca.fmax(v - _V_T, 0)


def _fV_inv(factor: ca.SX, beta: ca.SX | float, p: Symbols) -> ca.SX:
    # force factors at v = −1 and at v_t, drag included
    lowest, highest = ca.SX(-beta), ca.SX(_Z_T + beta * _V_T)
    short, long = clamp(factor, lowest, 1), clamp(factor, 1, highest)
    # fV(v) + βv = z: (β/A_f)v² − (1 + β + z/A_f)v + z − 1 = 0 for v = −w ≤ 0
    w = _positive_root(beta / _A_F, 1 + beta + short / _A_F, 1 - short)
    # βK v² + (K(F_len − z) + βE)v − E(z − 1) = 0 for v ≥ 0
    v = _positive_root(beta * _K, _K * (_F_LEN - long) + beta * _E, _E * (long - 1))
    beyond = ca.fmin(factor - lowest, 0) / (_SLOPE_0 + beta), ca.fmax(factor - highest, 0) / (_SLOPE_T + beta)
    return v - w + beyond[0] + beyond[1]


def _positive_root(second: ca.SX | float, first: ca.SX, constant: ca.SX) -> ca.SX:
    """x ≥ 0 with second x² + first x = constant, all ≥ 0 but `first`, which is above 0."""
    return 2 * constant / (first + ca.sqrt(first**2 + 4 * second * constant))


def _root(second: ca.SX, first: ca.SX, constant: ca.SX) -> ca.SX:
    """The positive root x of second x² + first x = constant, `second` > 0; for a constant below 0 a negative number."""
    root = ca.sqrt(ca.fmax(first**2 + 4 * second * constant, 0))
    # without a difference of equal numbers, whatever the sign of `first`
    total = ca.fabs(first) + root + _TINY
    return (first >= 0) * 2 * constant / total + (first < 0) * total / (2 * second)


class _Thelen(CurveSet):
    """S(a) = ¼ + ¾a scales velocities, so the activation is the root of a quadratic equation."""

    def slowing(self, a: ca.SX, p: Symbols) -> ca.SX:
        return _S_0 + (1 - _S_0) * a

    def activation_of(self, active: ca.SX, f: ca.SX, u: ca.SX, p: Symbols) -> ca.SX:
        # of v/S = −u/(speed S) the hyperbolas are fractions, so F = a f fV(v/S) times S is quadratic in a
        w, v = ca.fmax(u / self.speed(p), 0), ca.fmax(-u / self.speed(p), 0)
        rest = 1 - _S_0
        # (1 − S₀)f a² + (f(S₀ − w + K F_len v/E) − (1 − S₀)F)a = F(S₀ + w/A_f + K v/E)
        curved = _root(
            rest * f,
            f * (_S_0 - w + _K * _F_LEN / _E * v) - rest * active,
            active * (_S_0 + w / _A_F + _K / _E * v),
        )
        # on the straight line fV = κ + s v/S: (1 − S₀)κf a² + (f(S₀κ + s v) − (1 − S₀)F)a = S₀F
        kappa = _Z_T - _SLOPE_T * _V_T
        straight = _root(rest * kappa * f, f * (_S_0 * kappa + _SLOPE_T * v) - rest * active, _S_0 * active)
        beyond = v > _V_T * self.slowing(curved, p)
        return curved + beyond * (straight - curved)


THELEN2003 = normalised(
    name="thelen2003",
    sentence="exponentials and Hill's hyperbolas; velocities scale with ¼ + ¾a; the tendon can be slack",
    source="Thelen, Journal of Biomechanical Engineering 2003; numbers and straight ends of OpenSim 4.6",
    tendon=tendon_numbers(0.04, _SOURCE),
    fibre=fibre_numbers(0.6, _SOURCE),
    fT=_fT,
    fT_inv=_fT_inv,
    fP=_fP,
    fL=_fL,
    fV=_fV,
    fV_inv=_fV_inv,
    toe_force=_F_TOE,
    kind=_Thelen,
)
