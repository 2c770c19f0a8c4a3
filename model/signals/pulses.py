"""Pulses on the plant's u₁ behind the controller: they drive a tendon slack on purpose."""

from __future__ import annotations

from ..block import Block, Parameter, Parameters, Symbols, symbols

PULSES = ("pulse1", "pulse2")


def pulses() -> Block:
    """Inputs u1 and the held gates of the pulses (0 or 1); output u1 with the pulses added."""
    u = symbols(["u1", *PULSES])
    parameters: Parameters = {
        f"{name}.amplitude": Parameter(0.0, f"height of {name} on u1", "chosen, docs/model.md#scenarios")
        for name in PULSES
    }
    p = symbols(parameters)
    total = u.u1
    for name in PULSES:
        total = total + p[f"{name}.amplitude"] * u[name]
    return Block("pulses", u=u, p=p, parameters=parameters, y=Symbols(u1=total), held=frozenset(PULSES))
