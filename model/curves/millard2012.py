"""The curves of Millard, Uchida, Seth and Delp: corners of quintic Bézier curves, with OpenSim's numbers.

Millard et al., Flexing computational muscle: modeling and simulation of musculotendon dynamics, Journal of
Biomechanical Engineering 135, 2013; corners and numbers as in OpenSim 4.6, Millard2012EquilibriumMuscle.
"""

from __future__ import annotations

import casadi as ca

from ..block import Symbols
from .bezier import Bezier, Knot, through
from .normalised import fibre_numbers, normalised, tendon_numbers

_SOURCE = "OpenSim 4.6, Millard2012EquilibriumMuscle"

# tendon: slope at F0 and beyond, over the mean slope; force at the end of the toe; curviness
_STIFFNESS, _F_TOE, _TENDON = 1.375, 2 / 3, 0.5
# passive force: slope at F0 and beyond, over the mean slope; slope of the foot; curviness
_PASSIVE_STIFFNESS, _FOOT, _PASSIVE = 2.0, 0.2, 0.75
# force-length factor: shortest and longest active length, end of the steep limb, slope there, least value, curviness
_SHORTEST, _LONGEST, _TRANSITION, _SHALLOW, _LEAST, _ACTIVE = 0.4441, 1.8123, 0.73, 0.8616, 0.1, 1.0
# half the width of the plateau; how much steeper than its chord the ascending limb is
_PLATEAU, _STEEPER = 0.05, 1.25
# force-velocity factor: slopes near −1, at 0, near 1; at −1 and 1; largest factor; how near; curviness of both sides
_SLOPES, _END_SLOPES, _LARGEST, _NEAR, _CONCENTRIC, _ECCENTRIC = (0.25, 5.0, 0.15), (0.125, 0.075), 1.4, 0.9, 0.6, 0.9


def _tendon(p: Symbols) -> Bezier:
    slope = _STIFFNESS / p.tendon_strain
    # the toe ends where the line through (1 + strain, 1) has the force _F_TOE
    toe = 1 + p.tendon_strain + (_F_TOE - 1) / slope
    # its foot is a tenth of the way along; from there a chord goes to the middle of the toe
    foot = 1 + (toe - 1) / 10
    middle = 1 + p.tendon_strain + (_F_TOE / 2 - 1) / slope
    chord = _F_TOE / 2 / (middle - foot)
    joint = Knot((foot + middle) / 2, chord * (middle - foot) / 2, chord)
    return through([Knot(1.0, 0.0, 0.0), joint, Knot(toe, _F_TOE, slope)], [_TENDON] * 2)


def _passive(p: Symbols) -> Bezier:
    slope = _PASSIVE_STIFFNESS / p.passive_strain
    # the foot is a tenth of the shorter of both lengths
    foot = 0.1 * ca.fmin(1 / slope, p.passive_strain)
    low = Knot(1 + foot, _FOOT * foot / 2, _FOOT)
    return through([Knot(1.0, 0.0, 0.0), low, Knot(1 + p.passive_strain, 1.0, slope)], [_PASSIVE] * 2)


def _elastic(p: Symbols) -> ca.SX:
    """1 without fibre damping. With it OpenSim takes the least factor and the slopes at both ends as 0."""
    return p.damping <= 0


def _active(p: Symbols) -> Bezier:
    shoulder = 1 - _PLATEAU
    end = 1 - _SHALLOW * (shoulder - _TRANSITION)
    ascending = Knot((_SHORTEST + _TRANSITION) / 2, end / 2, _STEEPER * end / (_TRANSITION - _SHORTEST))
    shallow = Knot((_TRANSITION + shoulder) / 2, (end + 1) / 2, _SHALLOW)
    steepest = -1 / (_LONGEST - _PLATEAU - (1 + _PLATEAU))
    descending = Knot((1 + _PLATEAU + _LONGEST) / 2, 0.5, steepest)
    least = _LEAST * _elastic(p)
    first, last = Knot(_SHORTEST, least, 0.0), Knot(_LONGEST, least, 0.0)
    return through([first, ascending, shallow, Knot(1.0, 1.0, 0.0), descending, last], [_ACTIVE] * 5)


def _velocity(p: Symbols) -> Bezier:
    near, isometric, far = _SLOPES
    fastest, longest = (slope * _elastic(p) for slope in _END_SLOPES)
    rest = 1 - _NEAR
    knots = [
        Knot(-1.0, 0.0, fastest),
        Knot(-_NEAR, (fastest + near) / 2 * rest, near),
        Knot(0.0, 1.0, isometric),
        Knot(_NEAR, _LARGEST - (far + longest) / 2 * rest, far),
        Knot(1.0, _LARGEST, longest),
    ]
    return through(knots, [_CONCENTRIC, _CONCENTRIC, _ECCENTRIC, _ECCENTRIC])


MILLARD2012 = normalised(
    name="millard2012",
    sentence="quintic Bézier curves, C²; the tendon can be slack, passive force from the optimal length on",
    source="Millard et al., Journal of Biomechanical Engineering 2013; corners and numbers of OpenSim 4.6",
    tendon=tendon_numbers(0.049, _SOURCE),
    fibre=fibre_numbers(0.7, _SOURCE),
    fT=lambda length, p: _tendon(p)(length),
    fT_inv=lambda force, p: _tendon(p).inverse(force),
    fP=lambda length, p: _passive(p)(length),
    fL=lambda length, p: _active(p)(length),
    fV=lambda v, p: _velocity(p)(v),
    fV_inv=lambda factor, beta, p: _velocity(p).inverse(factor, beta),
    toe_force=_F_TOE,
)
