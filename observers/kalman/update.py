"""The two halves of a Kalman filter for mean and covariance: a prediction, and scalar measurements one by one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from .model import Measurement


def predicted(P: ca.SX, F: Sequence[ca.SX], noise: ca.SX) -> ca.SX:
    """The covariance (n × n) after a motion that white noise drives.

    F: the motion as factors, the last one first applied; noise: what is added meanwhile, QT.
    """
    # P⁻ = F(P + QT/2)Fᵀ + QT/2
    P = P + noise / 2
    for factor in reversed(F):
        P = symmetric(factor @ P @ factor.T)
    return P + noise / 2


@dataclass(frozen=True)
class Update:
    """A measurement and what it changes: innovation ν and its variance S, gains K, mean and covariance afterwards."""

    i: int
    nu: ca.SX
    S: ca.SX
    K: ca.SX
    x: ca.SX
    P: ca.SX


def measured(x: ca.SX, P: ca.SX, measurement: Measurement, weight: ca.SX | float = 1.0) -> Update:
    """Mean x (n × 1) and covariance P after a measurement; weight 0: there was none, 1: there was."""
    # S = P_ii + R,  K = P_i/S,  x⁺ = x + K(y − x_i),  P⁺ = P − K P_iᵀ
    i, R = measurement.i, measurement.R
    S = P[i, i] + R
    nu, K = measurement.value - x[i], weight * P[:, i] / S
    after = P - K @ P[i, :]
    # P⁺_i = P_i R/S: the same, without the difference that a small R would be lost in
    after[i, :] = after[:, i] = P[:, i] * ((1 - weight) + weight * (R / S))
    return Update(i, nu, S, K, x + K * nu, symmetric(after))


def symmetric(P: ca.SX) -> ca.SX:
    """The lower triangle, mirrored: the upper one is never computed."""
    return ca.tril2symm(ca.tril(P))
