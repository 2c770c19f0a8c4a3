"""The bounded uncertainty Δ_Φ in the acceleration, and its derivative."""

from __future__ import annotations

from ..block import Block, symbols
from .reference import derivatives, signal, sine


def uncertainty(size: float = 0.005, source: str = "paper, [DeltaPhi]") -> Block:
    """Δ_Φ = 0.005 + 0.005 sin 0.8τ [DeltaPhi]. Outputs Delta, dDelta."""
    u = symbols("t")
    parameters = signal(size, size, 0.8, "the uncertainty", source)
    p = symbols(parameters)
    return Block("uncertainty", u=u, p=p, parameters=parameters, y=derivatives(sine(u, p), u.t, ["Delta", "dDelta"]))
