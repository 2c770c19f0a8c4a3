"""The activations from an observer's estimates, within what a muscle can do."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca

from ...model.block import Block, Parameter, Parameters, Symbols, symbols
from ...model.curves import CurveSet
from ...model.dialect import clamp, outside
from ...model.fibre import along_fibres
from ...model.symbols import hat
from ...model.system import PAIR, System

_CHOSEN = "chosen, docs/observers.md#activations"

LIMITS: Parameters = {
    "u_low": Parameter(-5.0, "smallest û_j that the activation is computed with, in l_opt·v_max", _CHOSEN, below=0),
    "u_high": Parameter(0.95, "largest û_j that the activation is computed with; g(1) = 0", _CHOSEN, above=0, below=1),
}


@dataclass(frozen=True)
class Formula:
    """The activation â of a muscle as an expression of `drive`, a symbol for û_j, which is to be within its limits.

    L_C: the length of its fibres; speed: the largest û_j of the muscle.
    """

    muscle: str
    a: ca.SX
    L_C: ca.SX
    drive: ca.SX
    low: ca.SX
    high: ca.SX
    speed: ca.SX | float


def activation_parameters(system: System = PAIR) -> Parameters:
    """All numbers that the activations take."""
    return {**system.length_parameters, **LIMITS, **system.curve_parameters}


def activation(curves: CurveSet, L_S: ca.SX, L_m: ca.SX, u: ca.SX, p: Symbols) -> ca.SX:
    """The activation, not limited, of a muscle of length L_m that shortens with velocity u."""
    # â_j = (Φ_S(x̂_{j+2}) − Φ_P(L̂_Cj))/(g(û_j) f(L̂_Cj))   [z]
    return curves.activation(*along_fibres(curves.Phi_S(L_S, p), L_m, L_S, u, p), p)


def formulas(system: System, u: Symbols, p: Symbols) -> Iterator[Formula]:
    """The activations of all muscles as their states, not yet limited, are in the estimates `u`."""
    q = [u[hat(name)] for name in system.joint("q")]
    for muscle, L_m in zip(system.muscles, system.lengths(q, p), strict=True):
        curve, numbers, drive = system.curves[muscle], p.part(muscle), ca.SX.sym("drive")
        L_S, speed = u[hat(system.name("L_S", muscle))], curve.speed(numbers)
        low, high = p.u_low * speed, p.u_high * speed
        a, (_, L_C, _) = activation(curve, L_S, L_m, drive, numbers), along_fibres(ca.SX(0), L_m, L_S, drive, numbers)
        yield Formula(muscle, a, L_C, drive, low, high, speed)


# the same behind all observers
@functools.lru_cache(maxsize=16)
def activation_estimate(system: System = PAIR) -> Block:
    """Inputs: the estimates; outputs the activations in [0, 1]; guards say when a limit is active."""
    u, parameters = symbols(system.estimates), activation_parameters(system)
    p = symbols(parameters)
    y, guards = Symbols(), Symbols()
    for f in formulas(system, u, p):
        u_hat, a_hat = (hat(system.name(signal, f.muscle)) for signal in ("u", "a"))
        drive = u[u_hat]
        a = ca.substitute(f.a, f.drive, clamp(drive, f.low, f.high))
        y[a_hat] = clamp(a, 0, 1)
        guards[f"{u_hat}_limit"] = outside(drive, f.low, f.high)
        guards[f"{a_hat}_limit"] = outside(a, 0, 1)
    return Block("activation", u=u, p=p, parameters=parameters, y=y, guards=guards)
