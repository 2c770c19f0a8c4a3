"""How stiff the tendons are where measured forces put them: what an observer with a noise model has in front of it."""

from __future__ import annotations

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.curves import NGUYEN2019, Curves, CurveSet, by_muscle, tendon_parameters
from .tendons import LENGTHS

# name of the slope → tendon length at which it is taken
SLOPES = {"slope1": "L_S1", "slope2": "L_S2"}

_FLOOR = {
    "least_slope": Parameter(
        0.05,
        "least slope of a tendon, in that at the end of its toe: a slack one has none",
        "chosen, docs/observers.md#kalman",
        above=0,
        most=1,
    )
}


def tendon_slopes(curves: Curves = NGUYEN2019) -> Block:
    """Inputs L_S1, L_S2; outputs slope1, slope2, limited from below."""
    u, parameters = symbols(LENGTHS), {**_FLOOR, **tendon_parameters(curves)}
    p, y = symbols(parameters), Symbols()
    for (slope, length), (muscle, curve) in zip(SLOPES.items(), by_muscle(curves).items(), strict=True):
        y[slope] = _slope(curve, u[length], p.part(muscle), p.least_slope)
    return Block("slopes", u=u, p=p, parameters=parameters, y=y)


def tendon_lines(curves: Curves = NGUYEN2019) -> Block:
    """Inputs y2, y3 and estimated lengths x3_hat, x4_hat; outputs the LENGTHS and SLOPES of tendons linear about these.

    A length and a slope at the measured force have that force's noise in common, which weighs high forces more.
    """
    estimates = {"x3_hat": "y2", "x4_hat": "y3"}
    u, parameters = symbols([*estimates, *estimates.values()]), {**_FLOOR, **tendon_parameters(curves)}
    p, lengths, slopes = symbols(parameters), Symbols(), Symbols()
    for (estimate, force), length, slope, (muscle, curve) in zip(
        estimates.items(), LENGTHS, SLOPES, by_muscle(curves).items(), strict=True
    ):
        numbers = p.part(muscle)
        # a slack tendon's length is not known, and is taken for that without force
        about = ca.fmax(u[estimate], curve.Phi_S_inv(ca.SX(0), numbers))
        slopes[slope] = _slope(curve, about, numbers, p.least_slope)
        # z_j = x̂ + (y_{j+1} − Φ_S(x̂))/p_j
        lengths[length] = about + (u[force] - curve.Phi_S(about, numbers)) / slopes[slope]
    return Block("tendon_lines", u=u, p=p, parameters=parameters, y=Symbols({**lengths, **slopes}))


def _slope(curve: CurveSet, length: ca.SX, numbers: Symbols, least: ca.SX) -> ca.SX:
    stiff = curve.Phi_S_prime(curve.Phi_S_inv(ca.SX(curve.toe_force(numbers)), numbers), numbers)
    # p_j = Φ′_S(L_Sj)
    return ca.fmax(curve.Phi_S_prime(length, numbers), least * stiff)
