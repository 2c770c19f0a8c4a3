"""How stiff the tendons are where measured forces put them: what an observer with a noise model has in front of it."""

from __future__ import annotations

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.curves import CurveSet
from ..model.symbols import hat
from ..model.system import PAIR, System


def slopes_of(system: System) -> dict[str, str]:
    """Name of each tendon's slope → the length at which it is taken."""
    return dict(zip(system.muscle("slope"), system.tendons, strict=True))


# of the pair
SLOPES = slopes_of(PAIR)

_FLOOR = {
    "least_slope": Parameter(
        0.05,
        "least slope of a tendon, in that at the end of its toe: a slack one has none",
        "chosen, docs/observers.md#kalman",
        above=0,
        most=1,
    )
}


def tendon_slopes(system: System = PAIR) -> Block:
    """Inputs are tendon lengths, L_S1 and L_S2 of the pair; outputs slopes, slope1 and slope2, limited from below."""
    u, parameters = symbols(system.tendons), {**_FLOOR, **system.tendon_parameters}
    p, y = symbols(parameters), Symbols()
    for (slope, length), muscle in zip(slopes_of(system).items(), system.muscles, strict=True):
        y[slope] = _slope(system.curves[muscle], u[length], p.part(muscle), p.least_slope)
    return Block("slopes", u=u, p=p, parameters=parameters, y=y)


def tendon_lines(system: System = PAIR) -> Block:
    """Inputs are estimated tendon lengths and the measured forces; outputs tendons linear about these, as z and slope.

    A length and a slope at the measured force have that force's noise in common, which weighs high forces more.
    """
    estimates = [hat(name) for name in system.muscle("L_S")]
    u, parameters = symbols([*estimates, *system.muscle("y")]), {**_FLOOR, **system.tendon_parameters}
    p, lengths, slopes = symbols(parameters), Symbols(), Symbols()
    for estimate, muscle in zip(estimates, system.muscles, strict=True):
        curve, numbers = system.curves[muscle], p.part(muscle)
        length, slope, force = (system.name(signal, muscle) for signal in ("z", "slope", "y"))
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
