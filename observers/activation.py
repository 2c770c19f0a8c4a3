"""The activations from an observer's estimates, within what a muscle can do."""

from __future__ import annotations

from ..model.block import Block, Parameter, Parameters, Symbols, symbols
from ..model.curves import NGUYEN2019, CurveSet, per_muscle
from ..model.dialect import clamp, outside
from ..model.muscle import activation
from ..model.skeleton import LENGTH, lengths
from ..model.symbols import MUSCLES
from .ports import ESTIMATES

_CHOSEN = "chosen, spec §2"

LIMITS: Parameters = {
    "u_low": Parameter(-5.0, "smallest û_j that the activation is computed with", _CHOSEN, below=0),
    "u_high": Parameter(0.95, "largest û_j that the activation is computed with; g(1) = 0", _CHOSEN, above=0, below=1),
}


def activation_estimate(curves: CurveSet = NGUYEN2019) -> Block:
    """Inputs: the estimates; outputs a1_hat, a2_hat in [0, 1]; guards say when a limit is active."""
    u = symbols(ESTIMATES)
    parameters = {"C": LENGTH, **LIMITS, **per_muscle(curves.parameters)}
    p = symbols(parameters)
    y, guards = Symbols(), Symbols()
    for j, (muscle, L_m) in enumerate(zip(MUSCLES, lengths(u.x1_hat, p.C), strict=True), start=1):
        curve, L_S, drive = p.part(muscle), u[f"x{j + 2}_hat"], u[f"u{j}_hat"]
        # â_j = (Φ_S(x̂_{j+2}) − Φ_P(L̂_Cj))/(g(û_j) f(L̂_Cj))   [z]
        a = activation(curves.Phi_S(L_S, curve), L_m - L_S, clamp(drive, p.u_low, p.u_high), curves, curve)
        y[f"a{j}_hat"] = clamp(a, 0, 1)
        guards[f"u{j}_hat_limit"] = outside(drive, p.u_low, p.u_high)
        guards[f"a{j}_hat_limit"] = outside(a, 0, 1)
    return Block("activation", u=u, p=p, parameters=parameters, y=y, guards=guards)
