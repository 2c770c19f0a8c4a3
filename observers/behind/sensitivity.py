"""How the estimates of a muscle move with the numbers that they are computed with, while what is measured stays.

The filtered force, position and velocity hardly depend on the muscle's numbers θ. So the tendon has the length at which
it has that force, Φ_S(L_S, θ) = F, and everything else follows from it.
"""

from __future__ import annotations

import casadi as ca

from ...model.block import Symbols, symbols
from ...model.curves import CurveSet
from ...model.curves.sizes import SIZES, relative
from ...model.dialect import clamp
from ...model.fibre import along_fibres
from .activation import activation

# an additive error of the force, and of the muscle's length
FORCE_BIAS, LENGTH_BIAS = "force_bias", "length_bias"
PENNATION = "pennation"
MUSCLE_ESTIMATES = ("tendon_length", "fibre_length", "fibre_velocity", "activation")
_INPUTS = ("L_m", "dL_m", "L_S", "u", "u_low", "u_high")


def numbers(curves: CurveSet, oblique: bool) -> tuple[str, ...]:
    """All that estimates of a muscle are computed with: sizes, the other numbers of its curves, errors of sensors.

    oblique: its fibres have a pennation.
    """
    return (*muscle_numbers(curves, oblique), FORCE_BIAS, LENGTH_BIAS)


def muscle_numbers(curves: CurveSet, oblique: bool) -> tuple[str, ...]:
    """The same without sensors: what a muscle is."""
    return tuple(dict.fromkeys((*SIZES, *curves.parameters, *([PENNATION] if oblique else ()))))


def in_own_sizes(curves: CurveSet, theta: Symbols) -> Symbols:
    """The numbers of a muscle, with which its curves take parts of its own F_max, l_opt and l_opt v_max."""
    angle = theta.only([PENNATION]) if PENNATION in theta else Symbols()
    p = Symbols({**theta, **relative(theta, theta)}).only(curves.parameters)
    return Symbols({**p, "l_opt": ca.SX(1), **angle})


def sensitivities(curves: CurveSet, oblique: bool) -> ca.Function:
    """(inputs 6 × 1, `numbers` n × 1) → S = d MUSCLE_ESTIMATES/d numbers (4 × n), in any consistent units such as SI.

    Inputs are the estimated length of the muscle, its rate, the tendon length and the shortening velocity u, and the
    limits of u in l_opt v_max; fibre velocity is −u. Not finite where the tendon has no slope.
    """
    x, theta = symbols(_INPUTS), symbols(numbers(curves, oblique))
    angle = theta.only([PENNATION]) if oblique else Symbols()
    p = in_own_sizes(curves, theta)
    L_m, drive, speed = x.L_m + theta[LENGTH_BIAS], ca.SX.sym("drive"), theta.l_opt * theta.v_max
    a = activation(curves, x.L_S / theta.l_opt, L_m / theta.l_opt, drive / speed, p)
    _, L_C, shortening = along_fibres(ca.SX(0), L_m, x.L_S, drive, Symbols({"l_opt": theta.l_opt, **angle}))
    h = ca.vertcat(x.L_S, L_C, -shortening, a)
    force = theta.F_max * curves.Phi_S(x.L_S / theta.l_opt, p) - theta[FORCE_BIAS]

    of = theta.vector()
    # ℓ = ∂L_S/∂θ = −(∂Φ_S/∂θ)/Φ′_S,  ℓ̇ = ∂ℓ/∂L_S L̇_S,  L̇_S = L̇_m + u
    ell = -ca.jacobian(force, of) / ca.jacobian(force, x.L_S)
    rate = ca.jtimes(ell, x.L_S, x.dL_m + x.u)
    # S = ∂h/∂θ + ∂h/∂L_S ℓ + ∂h/∂u ℓ̇
    S = ca.jacobian(h, of) + ca.jacobian(h, x.L_S) @ ell + ca.jacobian(h, drive) @ rate
    S = ca.substitute(S, drive, clamp(x.u, x.u_low * speed, x.u_high * speed))
    return ca.Function("sensitivities", [x.vector(), of], [ca.densify(S)])
