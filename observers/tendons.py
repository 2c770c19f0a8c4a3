"""The lengths of the tendons as their measured forces tell them: what all observers have in front of them."""

from __future__ import annotations

from ..model.block import Block, Symbols, symbols
from ..model.curves import NGUYEN2019, CurveSet, per_muscle
from ..model.symbols import MUSCLES

# name of the length → sensor that tells it
LENGTHS = {"L_S1": "y2", "L_S2": "y3"}


def tendons(curves: CurveSet = NGUYEN2019) -> Block:
    """Inputs y2, y3; outputs L_S1, L_S2."""
    u, parameters = symbols(LENGTHS.values()), per_muscle(curves.tendon)
    p = symbols(parameters)
    # L_Sj = Φ_S⁻¹(y_{j+1})   [PhiSj]
    y = Symbols({L: curves.Phi_S_inv(u[f], p.part(m)) for m, (L, f) in zip(MUSCLES, LENGTHS.items(), strict=True)})
    return Block("tendons", u=u, p=p, parameters=parameters, y=y)
