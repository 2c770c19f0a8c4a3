"""What a muscle's numbers leave unexplained of its force, when its activation is known.

As for `sensitivities` the filtered force, position and velocity hardly depend on the muscle's numbers θ. So they are
given, and the tendon has the length at which it has that force, Φ_S(L_S, θ) = F.
"""

from __future__ import annotations

import casadi as ca

from ...model.block import symbols
from ...model.curves import CurveSet
from ...model.fibre import along_fibres
from .sensitivity import in_own_sizes, muscle_numbers

# tendon force and its rate, length of the muscle and its rate, activation
KNOWN = ("F", "dF", "L_m", "dL_m", "a")


def balance(curves: CurveSet, oblique: bool) -> ca.Function:
    """(KNOWN 5 × 1, `muscle_numbers` n × 1) → e, ∂e/∂KNOWN, ∂e/∂numbers as a column, in any consistent units.

    e is the force along the fibres that the tendon asks for, less what they have. Not finite where the tendon has no
    slope.
    """
    x, theta = symbols(KNOWN), symbols(muscle_numbers(curves, oblique))
    p, speed = in_own_sizes(curves, theta), theta.l_opt * theta.v_max
    F = x.F / theta.F_max
    # Φ_S(L_S, θ) = F,  L̇_S = Ḟ/Φ′_S,  u = L̇_S − L̇_m   [lsdot1], [lsdot2]
    L_S = curves.Phi_S_inv(F, p)
    dL_S = x.dF / theta.F_max / curves.Phi_S_prime(L_S, p) * theta.l_opt
    along, L_C, shortening = along_fibres(F, x.L_m / theta.l_opt, L_S, (dL_S - x.dL_m) / speed, p)
    # e = F − (a f g(u) + Φ_P)
    e = theta.F_max * (along - curves.force(L_C, x.a, shortening, p))
    column = ca.vertcat(e, *(ca.jacobian(e, of).T for of in (x.vector(), theta.vector())))
    return ca.Function("balance", [x.vector(), theta.vector()], [ca.densify(column)])


def tendon_force(curves: CurveSet, oblique: bool) -> ca.Function:
    """(L_S, `muscle_numbers` n × 1) → Φ_S and Φ′_S as a column, in any consistent units."""
    L_S, theta = ca.SX.sym("L_S"), symbols(muscle_numbers(curves, oblique))
    F = theta.F_max * curves.Phi_S(L_S / theta.l_opt, in_own_sizes(curves, theta))
    return ca.Function("tendon_force", [L_S, theta.vector()], [ca.densify(ca.vertcat(F, ca.jacobian(F, L_S)))])
