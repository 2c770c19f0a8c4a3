"""The curves of Thelen, whose force-velocity relation depends on the activation, with OpenSim's numbers.

Thelen, Adjustment of muscle mechanics model parameters to simulate dynamic contractions in older adults, Journal of
Biomechanical Engineering 125, 2003; numbers, and straight lines where the hyperbolas end, as in OpenSim 4.6.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca

from ..block import Parameter, Parameters, Symbols
from ..dialect import clamp
from .curve_set import CurveSet
from .normalised import fibre_numbers, normalised, tendon_numbers

_SOURCE = "OpenSim 4.6, Thelen2003Muscle"

# tendon: force at the end of the toe, shape of the toe
_F_TOE, _K_TOE = 0.33, 3.0
# the part of the largest force factor at which the straight line begins
_THRESHOLD = 0.95
# velocity of a muscle of activation 0, in that of a fully active one
_S_0 = 0.25
# keeps 0/0 out of the root for a fibre without force at its largest velocity
_TINY = 1e-300

_FIBRE: Parameters = {
    **fibre_numbers(0.6, _SOURCE),
    "k_PE": Parameter(5.0, "shape of the passive force", _SOURCE, above=0),
    "gamma": Parameter(0.45, "width of the force-length factor", _SOURCE, above=0),
    "A_f": Parameter(0.25, "Hill's constant", _SOURCE, above=0),
    "F_len": Parameter(1.4, "largest force factor while lengthening", _SOURCE, above=1 / _THRESHOLD),
}


@dataclass(frozen=True)
class _Lengthening:
    """The hyperbola v = (z − 1)E/(K(F_len − z)) and where it becomes straight."""

    E: ca.SX
    K: ca.SX
    z: ca.SX  # force factor
    v: ca.SX  # velocity
    slope: ca.SX  # dz/dv


def _lengthening(p: Symbols) -> _Lengthening:
    E, K, z = p.F_len - 1, 2 + 2 / p.A_f, _THRESHOLD * p.F_len
    v = (z - 1) * E / (K * (p.F_len - z))
    return _Lengthening(E, K, z, v, slope=K * E**2 / (K * v + E) ** 2)


def _least_slope(p: Symbols) -> ca.SX:
    """dz/dv at the largest shortening velocity."""
    return 1 / (1 + 1 / p.A_f)


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
    return ca.expm1(p.k_PE * ca.fmax(length - 1, 0) / p.passive_strain) / ca.expm1(p.k_PE)


def _fL(length: ca.SX, p: Symbols) -> ca.SX:
    # fL = exp(−(l − 1)²/γ)
    return ca.exp(-((length - 1) ** 2) / p.gamma)


def _fV(v: ca.SX, p: Symbols) -> ca.SX:
    """The force factor of a fully active muscle; S(a) scales the velocity of others."""
    end = _lengthening(p)
    short, long = clamp(v, -1, 0), clamp(v, 0, end.v)
    # v ≤ 0: (1 + v)/(1 − v/A_f);  v > 0: (K F_len v + E)/(K v + E); the other factor is 1, and the lines are 0
    hyperbolas = (1 + short) / (1 - short / p.A_f) * (end.K * p.F_len * long + end.E) / (end.K * long + end.E)
    return hyperbolas + _least_slope(p) * ca.fmin(v + 1, 0) + end.slope * ca.fmax(v - end.v, 0)


def _fV_inv(factor: ca.SX, beta: ca.SX | float, p: Symbols) -> ca.SX:
    end = _lengthening(p)
    # force factors at v = −1 and at the end of the hyperbola, drag included
    lowest, highest = ca.SX(-beta), end.z + beta * end.v
    short, long = clamp(factor, lowest, 1), clamp(factor, 1, highest)
    # fV(v) + βv = z: (β/A_f)w² + (1 + β + z/A_f)w = 1 − z for w = −v ≥ 0
    w = _positive_root(beta / p.A_f, 1 + beta + short / p.A_f, 1 - short)
    # βK v² + (K(F_len − z) + βE)v = E(z − 1) for v ≥ 0
    v = _positive_root(beta * end.K, end.K * (p.F_len - long) + beta * end.E, end.E * (long - 1))
    lines = ca.fmin(factor - lowest, 0) / (_least_slope(p) + beta), ca.fmax(factor - highest, 0) / (end.slope + beta)
    return v - w + lines[0] + lines[1]


def _positive_root(second: ca.SX | float, first: ca.SX, constant: ca.SX) -> ca.SX:
    """x ≥ 0 with second x² + first x = constant, all ≥ 0 but `first`, which is above 0."""
    return 2 * constant / (first + ca.sqrt(first**2 + 4 * second * constant))


def _root(second: ca.SX, first: ca.SX, constant: ca.SX) -> ca.SX:
    """The larger root x of second x² + first x = constant; second > 0, constant ≥ 0."""
    root = ca.sqrt(first**2 + 4 * second * constant)
    # without a difference of equal numbers, whatever the sign of `first`
    total = ca.fabs(first) + root + _TINY
    return (first >= 0) * 2 * constant / total + (first < 0) * total / (2 * second)


class _Thelen(CurveSet):
    """S(a) = ¼ + ¾a scales velocities, so the activation is the root of a quadratic equation."""

    def slowing(self, a: ca.SX, p: Symbols) -> ca.SX:
        return _S_0 + (1 - _S_0) * a

    def activation_of(self, active: ca.SX, f: ca.SX, u: ca.SX, p: Symbols) -> ca.SX:
        end, rest = _lengthening(p), 1 - _S_0
        # no activation gives a force below 0: from there on as if it were isometric, so that a limit shows
        below, active = ca.fmin(active, 0) / f, ca.fmax(active, 0)
        w, v = ca.fmax(u / self.speed(p), 0), ca.fmax(-u / self.speed(p), 0)
        # F = a f fV(v/S) with a hyperbola for fV, times S and the denominator, is quadratic in a:
        # (1 − S₀)f a² + (f(S₀ − w + K F_len v/E) − (1 − S₀)F)a = F(S₀ + w/A_f + K v/E)
        ratio = end.K / end.E * v
        linear = f * (_S_0 - w + p.F_len * ratio) - rest * active
        curved = _root(rest * f, linear, active * (_S_0 + w / p.A_f + ratio))
        # with the line fV = κ + s v/S: (1 − S₀)κf a² + (f(S₀κ + s v) − (1 − S₀)F)a = S₀F
        kappa = end.z - end.slope * end.v
        linear = f * (_S_0 * kappa + end.slope * v) - rest * active
        straight = _root(rest * kappa * f, linear, _S_0 * active)
        return below + curved + (v > end.v * self.slowing(curved, p)) * (straight - curved)


THELEN2003 = normalised(
    name="thelen2003",
    sentence="exponentials and Hill's hyperbolas; velocities scale with ¼ + ¾a; the tendon can be slack",
    source="Thelen, Journal of Biomechanical Engineering 2003; numbers and straight ends of OpenSim 4.6",
    tendon=tendon_numbers(0.04, _SOURCE),
    fibre=_FIBRE,
    fT=_fT,
    fT_inv=_fT_inv,
    fP=_fP,
    fL=_fL,
    fV=_fV,
    fV_inv=_fV_inv,
    toe_force=_F_TOE,
    kind=_Thelen,
)
