"""The lengths of the tendons as their measured forces tell them: what observers have in front of them."""

from __future__ import annotations

import casadi as ca

from ..model.block import Block, Symbols, symbols
from ..model.system import PAIR, System

# of the pair: name of the length → sensor that tells it
LENGTHS = PAIR.tendons


def tendons(system: System = PAIR) -> Block:
    """Inputs are the measured forces, y2 and y3 of the pair; outputs the lengths that they tell, L_S1 and L_S2."""
    u, p = symbols(system.tendons.values()), symbols(system.tendon_parameters)
    # L_Sj = Φ_S⁻¹(y_{j+1})   [PhiSj]
    y = Symbols(
        {
            length: system.curves[muscle].Phi_S_inv(u[force], p.part(muscle))
            for muscle, (length, force) in zip(system.muscles, system.tendons.items(), strict=True)
        }
    )
    return Block("tendons", u=u, p=p, parameters=system.tendon_parameters, y=y)


def tendons_of_a_step(stages: int, system: System = PAIR) -> Block | None:
    """The same at all stages of a step at once, for less; None if some curves have no such inverse.

    Inputs y2.0, y3.0, y2.1 …; outputs L_S1.0, L_S2.0, L_S1.1 …, and `doubt`: 1 where these may be wrong.
    """
    u = symbols(f"{y}.{i}" for i in range(stages) for y in system.tendons.values())
    p, lengths, doubt = symbols(system.tendon_parameters), Symbols(), ca.SX(0)
    for muscle, (length, force) in zip(system.muscles, system.tendons.items(), strict=True):
        if (inverse := system.curves[muscle].Phi_S_inv_near) is None:
            return None
        values, wrong = inverse([u[f"{force}.{i}"] for i in range(stages)], p.part(muscle))
        lengths |= {f"{length}.{i}": value for i, value in enumerate(values)}
        doubt = ca.fmax(doubt, wrong)
    y = lengths.only(f"{length}.{i}" for i in range(stages) for length in system.tendons)
    parameters = system.tendon_parameters
    return Block("tendons_of_a_step", u=u, p=p, parameters=parameters, y=Symbols({**y, "doubt": doubt}))
