"""What the models of the Kalman filter share: chains of integrators, their start, and the measured acceleration."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import casadi as ca

from ...model.block import Symbols
from .model import Measurement

# names of an input and its derivatives, and which of these the white noise is
Chain = tuple[tuple[str, ...], ca.SX]


def known_acceleration(at: Symbols, pull1: ca.SX, pull2: ca.SX) -> ca.SX:
    """The part of ẋ₂ that is measured; pull1, pull2: slopes of the tendons over m."""
    # acc − (p₂z₂ − p₁z₁)/m
    return at.acc - (pull2 * at.L_S2 - pull1 * at.L_S1)


def start(
    measurements: Sequence[Measurement],
    chains: Iterable[tuple[Chain, ca.SX]],
    p: Symbols,
    index: Mapping[str, int],
) -> tuple[ca.SX, ca.SX]:
    """Mean and variances (n × 1); chains: each with the sd of its first. A derivative not in use is known to be 0."""
    mean, variance = ca.SX(len(index), 1), ca.SX(len(index), 1)
    for measurement in measurements:
        mean[measurement.i], variance[measurement.i] = measurement.value, p.start_sigma**2 * measurement.R
    if "x2" in index:
        variance[index["x2"]] = p.start_x2**2
    for (names, order), sd in chains:
        for i, name in enumerate(names):
            variance[index[name]] = (sd * p.start_rate**i) ** 2 * (order > i)
    return mean, variance


def last_in_use(chain: Chain, index: Mapping[str, int]) -> ca.SX:
    """The state (n × 1 of 0 and 1) of a chain that is driven: its last derivative in use."""
    names, order = chain
    driven = ca.SX(len(index), 1)
    for i, name in enumerate(names, start=1):
        driven[index[name]] = order == i
    return driven
