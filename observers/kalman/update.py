"""The two halves of a Kalman filter for mean and covariance: a prediction, and scalar measurements one by one."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca


def predicted(P: ca.SX, F: Sequence[ca.SX], noise: ca.SX) -> ca.SX:
    """The covariance (n × n) after a motion that white noise drives.

    F: the motion as factors, the last one first applied; noise: what is added meanwhile, QT.
    """
    # P⁻ = F(P + QT/2)Fᵀ + QT/2
    P = P + noise / 2
    for factor in reversed(F):
        P = _symmetric(factor @ P @ factor.T)
    return P + noise / 2


def measured(x: ca.SX, P: ca.SX, i: int, value: ca.SX, R: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Mean (n × 1) and covariance after a measurement of state i, with noise of variance R."""
    # S = P_ii + R,  K = P_i/S,  x⁺ = x + K(y − x_i),  P⁺ = P − K P_iᵀ
    S = P[i, i] + R
    K = P[:, i] / S
    after = P - K @ P[i, :]
    # P⁺_i = P_i R/S: the same, without the difference that a small R would be lost in
    after[i, :] = after[:, i] = P[:, i] * (R / S)
    return x + K * (value - x[i]), _symmetric(after)


def _symmetric(P: ca.SX) -> ca.SX:
    """The lower triangle, mirrored: the upper one is never computed."""
    return ca.tril2symm(ca.tril(P))
