"""Activations or excitations given as signals, for a plant without a controller."""

from __future__ import annotations

from collections.abc import Iterable

import casadi as ca

from ..block import Block, Parameter, Parameters, Symbols, symbols
from ..dialect import clamp
from .reference import signal, sine

# offset and amplitude per muscle: anti-phase about an equal co-contraction
_DEFAULTS = {"activation1": (0.35, 0.1), "activation2": (0.35, -0.1)}
_FREQUENCY = 2.0


def given_activations() -> Block:
    """a_j = offset + amplitude sin(frequency τ). Outputs a1, a2."""
    u = symbols("t")
    parameters: dict[str, Parameters] = {
        name: signal(offset, amplitude, _FREQUENCY, f"a{name[-1]}", "chosen, docs/model.md#scenarios")
        for name, (offset, amplitude) in _DEFAULTS.items()
    }
    flat = {f"{name}.{key}": value for name, numbers in parameters.items() for key, value in numbers.items()}
    p = symbols(flat)
    y = Symbols({f"a{name[-1]}": sine(u, p.part(name)) for name in parameters})
    return Block("activations", u=u, p=p, parameters=flat, y=y)


_CHOSEN = "chosen, docs/mechanisms.md#simulations"


def signals_of(kind: str, muscles: Iterable[str]) -> Block:
    """For each muscle offset + amplitude sin(frequency τ + phase), within [0, 1]; its outputs are named after them."""
    u, p, y = symbols("t"), Symbols(), Symbols()
    parameters: dict[str, Parameter] = {}
    for muscle in muscles:
        numbers = signal(0.2, 0.1, 0.5, f"the {kind} of {muscle}", _CHOSEN)
        of = {**numbers, "phase": Parameter(0.0, f"phase of the {kind} of {muscle}", _CHOSEN, "rad")}
        own = symbols(of)
        y[muscle] = clamp(own.offset + own.amplitude * ca.sin(own.frequency * u.t + own.phase), 0, 1)
        parameters |= {f"{muscle}.{key}": number for key, number in of.items()}
        p |= {f"{muscle}.{key}": symbol for key, symbol in own.items()}
    return Block(kind, u=u, p=p, parameters=parameters, y=y)
