"""Curves in a muscle's own units, as the literature gives them, become a CurveSet in the units of the pair.

Own units: forces in F0, fibre lengths in l0, tendon lengths in lT, velocities in l0·vmax and positive when lengthening.
The pair's are F0, l0 and l0·vmax of muscle 1, and u is positive when shortening.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from ..block import Parameter, Parameters, Symbols
from .curve_set import Curve, CurveSet

# the v with fV(v) + βv = force factor, over (force factor, β)
Inverse = Callable[[ca.SX, ca.SX | float, Symbols], ca.SX]

_SCALE = "chosen: muscle 1 is the reference"


def tendon_numbers(strain: float, source: str) -> Parameters:
    """What every tendon has: its slack length, its strain at F0, and F0 itself."""
    return {
        "L_slack": Parameter(2.0, "tendon slack length, in optimal fibre lengths of muscle 1", _SCALE, above=0),
        "tendon_strain": Parameter(strain, "strain of the tendon at the force F_max", source, least=1e-3, most=1),
        "F_max": Parameter(1.0, "largest isometric force, in that of muscle 1", _SCALE, above=0),
    }


def fibre_numbers(strain: float, source: str) -> Parameters:
    """What every fibre has: its optimal length, its largest velocity, its passive strain and damping."""
    return {
        "l_opt": Parameter(1.0, "optimal fibre length, in that of muscle 1", _SCALE, above=0),
        "v_max": Parameter(1.0, "largest velocity in own l_opt per time, in that of muscle 1", _SCALE, above=0),
        "passive_strain": Parameter(
            strain, "strain of the fibre at the passive force F_max", source, least=0.01, most=10
        ),
        "damping": Parameter(
            0.0, "fibre damping: force in F_max per velocity in l_opt·v_max", "chosen", least=0, most=10
        ),
    }


def normalised(
    name: str,
    sentence: str,
    source: str,
    tendon: Parameters,
    fibre: Parameters,
    fT: Curve,
    fT_inv: Curve,
    fP: Curve,
    fL: Curve,
    fV: Curve,
    fV_inv: Inverse,
    toe_force: float,
    kind: type[CurveSet] = CurveSet,
) -> CurveSet:
    """The CurveSet of tendon force fT, passive force fP, force-length factor fL and force-velocity factor fV.

    fT_inv and fV_inv are inverses, the latter with a drag β; from the factor toe_force on the tendon is straight.
    """

    def speed(p: Symbols) -> ca.SX:
        """l0·vmax in that of muscle 1."""
        return p.l_opt * p.v_max

    def g_inv_damped(z: ca.SX, beta: ca.SX, p: Symbols) -> ca.SX:
        # z = fV(v) + (β speed) v,  u = −speed v
        return -speed(p) * fV_inv(z, beta * speed(p), p)

    return kind(
        name=name,
        sentence=sentence,
        source=source,
        tendon=tendon,
        fibre=fibre,
        # Φ_S = F0 fT(L_S/lT)
        Phi_S=lambda L, p: p.F_max * fT(L / p.L_slack, p),
        Phi_S_inv=lambda F, p: p.L_slack * fT_inv(F / p.F_max, p),
        # Φ_P = F0 fP(L_C/l0),  f = F0 fL(L_C/l0)
        Phi_P=lambda L_C, p: p.F_max * fP(L_C / p.l_opt, p),
        f=lambda L_C, p: p.F_max * fL(L_C / p.l_opt, p),
        # g(u) = fV(v),  v = −u/(l0·vmax)
        g=lambda u, p: fV(-u / speed(p), p),
        g_inv=lambda z, p: -speed(p) * fV_inv(z, 0.0, p),
        toe_force=lambda p: toe_force * p.F_max,
        speed=speed,
        # F0 damping v = −b u
        damping=lambda p: p.F_max * p.damping / speed(p),
        g_inv_damped=g_inv_damped,
    )
