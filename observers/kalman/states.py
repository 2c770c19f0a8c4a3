"""What the Kalman filter estimates: the states of the pair, and a chain of derivatives for each unknown input."""

from __future__ import annotations

import itertools

import casadi as ca

from ...model.block import Symbols
from ...model.symbols import STATES, hat
from ..behind.spread import entry

# the longest chain: an input, its rate, the rate of that
LONGEST = 3
# input → its chain; the last derivative in use is driven by white noise
CHAINS = {name: (name, f"d{name}", f"dd{name}") for name in ("Delta", "u1", "u2")}
QUANTITIES = (*STATES, *itertools.chain(*CHAINS.values()))
INDEX = {name: i for i, name in enumerate(QUANTITIES)}
MEAN = tuple(hat(name) for name in QUANTITIES)

# the upper triangle: a covariance is symmetric by construction
_PAIRS = tuple(itertools.combinations_with_replacement(QUANTITIES, 2))
ENTRIES = tuple(itertools.starmap(entry, _PAIRS))


def covariance(entries: Symbols) -> ca.SX:
    """The symmetric matrix (n × n) of the scalars in ENTRIES."""
    return unpacked(entries.vector(), len(QUANTITIES))


def scalars(P: ca.SX) -> Symbols:
    """The ENTRIES of a symmetric matrix."""
    return Symbols(zip(ENTRIES, ca.vertsplit(packed(P)), strict=True))


def packed(P: ca.SX) -> ca.SX:
    """The upper triangle of a symmetric matrix (n × n), row by row, as a column."""
    return ca.vertcat(*(P[i, j] for i, j in _triangle(P.shape[0])))


def unpacked(entries: ca.SX, n: int) -> ca.SX:
    """The symmetric matrix (n × n) of its upper triangle."""
    P = ca.SX(n, n)
    for k, (i, j) in enumerate(_triangle(n)):
        P[i, j] = P[j, i] = entries[k]
    return P


def _triangle(n: int) -> list[tuple[int, int]]:
    return list(itertools.combinations_with_replacement(range(n), 2))
