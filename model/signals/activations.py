"""Activations given as signals, for a plant without a controller."""

from __future__ import annotations

from ..block import Block, Parameters, Symbols, symbols
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
