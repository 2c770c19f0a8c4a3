"""What the fibres of a muscle see of its tendon: all of it, or a part where they are oblique."""

from __future__ import annotations

import casadi as ca

from .block import Parameter, Parameters, Symbols
from .curves import CurveSet

# the height of the fibres stays, whatever their length
PENNATION = Parameter(
    0.0, "angle between fibres and tendon at the optimal fibre length", "muscle file", "rad", least=0, most=1.4
)


def muscle_parameters(curves: CurveSet, oblique: bool) -> Parameters:
    """All numbers of a muscle: those of its curves, and the pennation of oblique fibres."""
    return {**curves.parameters, **({"pennation": PENNATION} if oblique else {})}


def along_fibres(F: ca.SX, L_m: ca.SX, L_S: ca.SX, u: ca.SX, p: Symbols) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Force, length and shortening velocity along the fibres.

    F: tendon force; L_m, L_S: lengths of muscle and tendon; u: how fast L_m − L_S shrinks, in the units
    of p, pennation in rad. With `pennation` among the numbers p the fibres are oblique, of constant height.
    """
    L = L_m - L_S
    if "pennation" not in p:
        return F, L, u
    # L_C cos α = L_m − L_S,  L_C sin α = l₀ sin α₀
    L_C = ca.sqrt(L**2 + (p.l_opt * ca.sin(p.pennation)) ** 2)
    cosine = L / L_C
    return F / cosine, L_C, u * cosine
