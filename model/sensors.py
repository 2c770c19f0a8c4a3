"""The sensors: positions and tendon forces, each with noise that is drawn outside and held."""

from __future__ import annotations

import math

from .block import Block, Parameter, Parameters, Symbols, symbols
from .system import System

_PAPER = "paper, §V, second simulation"
_CHOSEN = "chosen, docs/mechanisms.md#simulations"

# what they measure, and the noise of each
SENSED = ("x1", "Phi_S1", "Phi_S2")
NOISE_CHANNELS = ("w1", "w2", "w3")

NOISE: Parameters = {
    "x1": Parameter(0.0, "half-width of the uniform noise on the position", _PAPER + ": 0.001", least=0),
    "force": Parameter(0.0, "half-width of the uniform noise on both forces", _PAPER + ": 0.001", least=0),
    "drift": Parameter(0.0, "constant error of both forces", _PAPER + ": 0.001"),
}


def sensors() -> Block:
    """Those of the pair. Inputs x1, Phi_S1, Phi_S2 and the held noise w1, w2, w3 in (−1, 1]; outputs y1, y2, y3."""
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


def noise_channels(system: System) -> tuple[str, ...]:
    """The noise of each joint's and of each muscle's sensor."""
    return tuple(f"w.{of}" for of in (*system.joints, *system.muscles))


def mechanism_sensors(system: System) -> Block:
    """Those of any system. Inputs q of joints, Phi_S of muscles and the noise in (−1, 1]; outputs y of each."""
    parameters: dict[str, Parameter] = {}
    for joint in system.joints:
        parameters[f"position.{joint}"] = _number(f"half-width of the uniform noise on the position of {joint}", 0)
    for muscle in system.muscles:
        parameters[f"force.{muscle}"] = _number(f"half-width of the uniform noise on the force of {muscle}", 0)
        parameters[f"drift.{muscle}"] = _number(f"constant error of the force of {muscle}")
    noise = noise_channels(system)
    u = symbols([*system.joint("q"), *system.muscle("Phi_S"), *noise])
    p, y = symbols(parameters), Symbols()
    for joint in system.joints:
        y[system.name("y", joint)] = u[system.name("q", joint)] + p[f"position.{joint}"] * u[f"w.{joint}"]
    for muscle in system.muscles:
        force = u[system.name("Phi_S", muscle)] + p[f"drift.{muscle}"]
        y[system.name("y", muscle)] = force + p[f"force.{muscle}"] * u[f"w.{muscle}"]
    return Block("noise", u=u, p=p, parameters=parameters, y=y, held=frozenset(noise))


def _number(sentence: str, least: float = -math.inf) -> Parameter:
    return Parameter(0.0, sentence, _CHOSEN, least=least)
