"""The three sensors: position and two tendon forces, each with noise that is drawn outside and held."""

from __future__ import annotations

from .block import Block, Parameter, Parameters, Symbols, symbols

_PAPER = "paper, §V, second simulation"

# what they measure, and the noise of each
SENSED = ("x1", "Phi_S1", "Phi_S2")
NOISE_CHANNELS = ("w1", "w2", "w3")

NOISE: Parameters = {
    "x1": Parameter(0.0, "half-width of the uniform noise on the position", _PAPER + ": 0.001", least=0),
    "force": Parameter(0.0, "half-width of the uniform noise on both forces", _PAPER + ": 0.001", least=0),
    "drift": Parameter(0.0, "constant error of both forces", _PAPER + ": 0.001"),
}


def sensors() -> Block:
    """Inputs x1, Phi_S1, Phi_S2 and the held noise w1, w2, w3 in (−1, 1]; outputs y1, y2, y3."""
    u = symbols([*SENSED, *NOISE_CHANNELS])
    p = symbols(NOISE)
    y = Symbols(
        # y₁ = x₁, y₂ = Φ_S1, y₃ = Φ_S2   [y1]–[y3], plus noise
        y1=u.x1 + p.x1 * u.w1,
        y2=u.Phi_S1 + p.drift + p.force * u.w2,
        y3=u.Phi_S2 + p.drift + p.force * u.w3,
    )
    # its numbers are `noise.x1` and so on
    return Block("noise", u=u, p=p, parameters=NOISE, y=y, held=frozenset(NOISE_CHANNELS))
