"""The exponential of a sparse matrix: scaled down, summed as a series, squared up again."""

from __future__ import annotations

import casadi as ca

# of a matrix of norm 25, as stiff as a tendon is from sample to sample, the series leaves 1e−16: (25/2¹⁰)⁷/7!
_SQUARINGS, _TERMS = 10, 6


def exponential(A: ca.SX) -> ca.SX:
    """e^A (n × n), for a norm of A up to about 100."""
    identity, small = ca.SX.eye(A.shape[0]), A / 2**_SQUARINGS
    # Horner: 1 + A(1 + A/2(1 + A/3(…)))
    E = identity
    for k in reversed(range(1, _TERMS + 1)):
        E = identity + small @ E / k
    for _ in range(_SQUARINGS):
        E = E @ E
    return E


def driven(A: ca.SX, before: ca.SX, after: ca.SX, T: ca.SX) -> tuple[ca.SX, ca.SX]:
    """F and b of x(T) = F x(0) + b for ẋ = A x + w, where w (n × 1) goes straight from `before` to `after`."""
    n = A.shape[0]
    # two more states, 1 and t/T
    M = ca.SX(n + 2, n + 2)
    M[:n, :n], M[:n, n], M[:n, n + 1] = A * T, before * T, (after - before) * T
    M[n + 1, n] = 1
    E = exponential(ca.sparsify(M))
    return E[:n, :n], E[:n, n]
