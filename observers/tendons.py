"""The lengths of the tendons as their measured forces tell them: what observers have in front of them."""

from __future__ import annotations

import casadi as ca

from ..model.block import Block, Symbols, symbols
from ..model.curves import NGUYEN2019, Curves, by_muscle, tendon_parameters
from ..model.symbols import MUSCLES

# name of the length → sensor that tells it
LENGTHS = {"L_S1": "y2", "L_S2": "y3"}


def tendons(curves: Curves = NGUYEN2019) -> Block:
    """Inputs y2, y3; outputs L_S1, L_S2."""
    u, parameters = symbols(LENGTHS.values()), tendon_parameters(curves)
    p = symbols(parameters)
    # L_Sj = Φ_S⁻¹(y_{j+1})   [PhiSj]
    y = Symbols(
        {
            length: curve.Phi_S_inv(u[force], p.part(muscle))
            for (muscle, curve), (length, force) in zip(by_muscle(curves).items(), LENGTHS.items(), strict=True)
        }
    )
    return Block("tendons", u=u, p=p, parameters=parameters, y=y)


def tendons_of_a_step(stages: int, curves: Curves = NGUYEN2019) -> Block | None:
    """The same at all stages of a step at once, for less; None if the curves have no such inverse.

    Inputs y2.0, y3.0, y2.1 …; outputs L_S1.0, L_S2.0, L_S1.1 …, and `doubt`: 1 where these may be wrong.
    """
    near = {muscle: curve.Phi_S_inv_near for muscle, curve in by_muscle(curves).items()}
    u, parameters = symbols(f"{y}.{i}" for i in range(stages) for y in LENGTHS.values()), tendon_parameters(curves)
    p, lengths, doubt = symbols(parameters), Symbols(), ca.SX(0)
    for muscle, (length, force) in zip(MUSCLES, LENGTHS.items(), strict=True):
        if (inverse := near[muscle]) is None:
            return None
        values, wrong = inverse([u[f"{force}.{i}"] for i in range(stages)], p.part(muscle))
        lengths |= {f"{length}.{i}": value for i, value in enumerate(values)}
        doubt = ca.fmax(doubt, wrong)
    y = lengths.only(f"{length}.{i}" for i in range(stages) for length in LENGTHS)
    return Block("tendons_of_a_step", u=u, p=p, parameters=parameters, y=Symbols({**y, "doubt": doubt}))
