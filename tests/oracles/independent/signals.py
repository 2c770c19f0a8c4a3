"""What enters from outside as functions of time: reference, uncertainty, given activations, pulses."""

from collections.abc import Callable
from typing import Any

import numpy as np

from .parameters import Parameters, value
from .states import Array

Signal = Callable[[Any], tuple[Any, ...]]


def sine_reference(p: Parameters) -> Signal:
    o, a, w = (value(p, f"reference.{n}") for n in ("offset", "amplitude", "frequency"))
    # r = offset + amplitude sin ωτ, and ṙ, r̈, r‴
    return lambda t: (
        o + a * np.sin(w * t),
        a * w * np.cos(w * t),
        -a * w**2 * np.sin(w * t),
        -a * w**3 * np.cos(w * t),
    )


def sine_uncertainty(p: Parameters) -> Signal:
    o, a, w = (value(p, f"uncertainty.{n}") for n in ("offset", "amplitude", "frequency"))
    # [DeltaPhi] Δ_Φ = offset + amplitude sin ωτ, and Δ̇_Φ
    return lambda t: (o + a * np.sin(w * t), a * w * np.cos(w * t))


def sine_activations(p: Parameters) -> Signal:
    (o1, a1, w1), (o2, a2, w2) = (
        [value(p, f"activation{j}.{n}") for n in ("offset", "amplitude", "frequency")] for j in (1, 2)
    )
    # a_j = offset + amplitude sin ωτ
    return lambda t: (o1 + a1 * np.sin(w1 * t), o2 + a2 * np.sin(w2 * t))


def pulses(p: Parameters, h: float, steps: Any) -> Array:
    """The pulse on u₁ during each step: constant over a step, edges in whole steps."""
    k, total = np.asarray(steps), np.zeros(np.shape(steps))
    edges = (np.atleast_1d(np.asarray(value(p, f"pulse.{n}"), float)) for n in ("amplitude", "start", "stop"))
    for amplitude, start, stop in zip(*edges, strict=True):
        total = total + amplitude * ((k >= round(start / h)) & (k < round(stop / h)))
    return total
