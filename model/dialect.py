"""Branch-free building blocks: symbols are not Python values, so switching is arithmetic."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import casadi as ca

# keeps e/(δ + |e|) defined for e = δ = 0 and changes no other value
_TINY = 1e-300
# no rate is larger, and a product with it is finite
_HUGE = 1e300


def clamp(value: ca.SX, low: ca.SX | float, high: ca.SX | float) -> ca.SX:
    """`value` limited to [low, high]."""
    return ca.fmin(ca.fmax(value, low), high)


def outside(value: ca.SX, low: ca.SX | float, high: ca.SX | float) -> ca.SX:
    """1 where `clamp` changes the value, else 0."""
    return ca.logic_or(value < low, value > high)


def chosen(rows: Sequence[Sequence[ca.SX | float]], beyond: Sequence[ca.SX]) -> list[ca.SX]:
    """The row of a table that a value is in: the first, or the last one whose flag in `beyond` is 1."""
    row = [ca.SX(number) for number in rows[0]]
    for flag, (old, new) in zip(beyond, itertools.pairwise(rows), strict=True):
        row = [value + flag * (b - a) for value, a, b in zip(row, old, new, strict=True)]
    return row


def sg(error: ca.SX, delta: ca.SX) -> ca.SX:
    """sg_δ(e) = e/(δ + |e|), the smoothed sign with boundary layer δ [deltas]; δ = 0 is the sign itself."""
    return error / (ca.fabs(error) + (delta + _TINY))


def no_lower(rate: ca.SX, value: ca.SX, low: ca.SX | float) -> ca.SX:
    """The projection of the rate of `value` that keeps it above `low`: a fall ends there."""
    return ca.fmax(rate, -_HUGE * (value > low))


def no_higher(rate: ca.SX, value: ca.SX, high: ca.SX | float) -> ca.SX:
    """The projection of the rate of `value` that keeps it below `high`: a rise ends there."""
    return ca.fmin(rate, _HUGE * (value < high))


def root(error: ca.SX) -> ca.SX:
    """|e|^½."""
    return ca.sqrt(ca.fabs(error))


def dead_zone(value: ca.SX, width: ca.SX) -> ca.SX:
    """|value| where it exceeds `width`, else 0."""
    return (ca.fabs(value) > width) * ca.fabs(value)


def solved(M: ca.SX, rhs: ca.SX) -> ca.SX:
    """M⁻¹ rhs, M symmetric and positive."""
    return rhs / M if M.is_scalar() else ca.ldl_solve(rhs, *ca.ldl(ca.densify(M)))
