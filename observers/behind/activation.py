"""The activations from an observer's estimates, within what a muscle can do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca

from ...model.block import Block, Parameter, Parameters, Symbols, symbols
from ...model.curves import NGUYEN2019, Curves, CurveSet, by_muscle, curve_parameters
from ...model.dialect import clamp, outside
from ...model.skeleton.load import LENGTH, lengths
from ...model.symbols import MUSCLES
from ..ports import ESTIMATES

_CHOSEN = "chosen, docs/observers.md#activations"

LIMITS: Parameters = {
    "u_low": Parameter(-5.0, "smallest û_j that the activation is computed with, in l_opt·v_max", _CHOSEN, below=0),
    "u_high": Parameter(0.95, "largest û_j that the activation is computed with; g(1) = 0", _CHOSEN, above=0, below=1),
}


@dataclass(frozen=True)
class Formula:
    """The activation â of muscle j as an expression of `drive`, a symbol for û_j, which is to be within its limits.

    speed: the largest û_j of the muscle.
    """

    j: int
    a: ca.SX
    drive: ca.SX
    low: ca.SX
    high: ca.SX
    speed: ca.SX | float


def activation_parameters(curves: Curves) -> Parameters:
    """All numbers that the activations take."""
    return {"C": LENGTH, **LIMITS, **curve_parameters(curves)}


def activation(curves: CurveSet, L_S: ca.SX, L_m: ca.SX, u: ca.SX, p: Symbols) -> ca.SX:
    """The activation, not limited, of a muscle of length L_m that shortens with velocity u."""
    # â_j = (Φ_S(x̂_{j+2}) − Φ_P(L̂_Cj))/(g(û_j) f(L̂_Cj))   [z]
    return curves.activation(curves.Phi_S(L_S, p), L_m - L_S, u, p)


def formulas(curves: Curves, u: Symbols, p: Symbols) -> Iterator[Formula]:
    """The activations of both muscles as their states, not yet limited, are in the estimates `u`."""
    sets = by_muscle(curves)
    for j, (muscle, L_m) in enumerate(zip(MUSCLES, lengths(u.x1_hat, p.C), strict=True), start=1):
        curve, numbers, L_S, drive = sets[muscle], p.part(muscle), u[f"x{j + 2}_hat"], ca.SX.sym("drive")
        speed = curve.speed(numbers)
        low, high = p.u_low * speed, p.u_high * speed
        yield Formula(j, activation(curve, L_S, L_m, drive, numbers), drive, low, high, speed)


def activation_estimate(curves: Curves = NGUYEN2019) -> Block:
    """Inputs: the estimates; outputs a1_hat, a2_hat in [0, 1]; guards say when a limit is active."""
    u, parameters = symbols(ESTIMATES), activation_parameters(curves)
    p = symbols(parameters)
    y, guards = Symbols(), Symbols()
    for f in formulas(curves, u, p):
        drive = u[f"u{f.j}_hat"]
        a = ca.substitute(f.a, f.drive, clamp(drive, f.low, f.high))
        y[f"a{f.j}_hat"] = clamp(a, 0, 1)
        guards[f"u{f.j}_hat_limit"] = outside(drive, f.low, f.high)
        guards[f"a{f.j}_hat_limit"] = outside(a, 0, 1)
    return Block("activation", u=u, p=p, parameters=parameters, y=y, guards=guards)
