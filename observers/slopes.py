"""How stiff the tendons are where measured forces put them: what an observer with a noise model has in front of it."""

from __future__ import annotations

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.curves import NGUYEN2019, Curves, by_muscle, tendon_parameters
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
        numbers = p.part(muscle)
        stiff = curve.Phi_S_prime(curve.Phi_S_inv(ca.SX(curve.toe_force(numbers)), numbers), numbers)
        # p_j = Φ′_S(L_Sj)
        y[slope] = ca.fmax(curve.Phi_S_prime(u[length], numbers), p.least_slope * stiff)
    return Block("slopes", u=u, p=p, parameters=parameters, y=y)
