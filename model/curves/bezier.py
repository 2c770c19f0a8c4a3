"""Curves of corners: quintic Bézier segments from tangent to tangent, C² where they meet, straight beyond the ends.

Millard, Uchida, Seth and Delp, Flexing computational muscle, Journal of Biomechanical Engineering 135, 2013.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from ..dialect import chosen, clamp

Number = ca.SX | float
# where a coordinate begins, and the three steps by which its control points rise
Rise = tuple[Number, Number, Number, Number]

# from the straight line: three are good to 4e−11 for Millard's curves, four to the last bits
_HALLEY_STEPS = 4
# keeps the cube root's derivative finite at the beginning
_TINY = 1e-45


@dataclass(frozen=True)
class Knot:
    """A point of the curve and its slope there."""

    x: Number
    y: Number
    slope: Number


@dataclass(frozen=True)
class Bezier:
    """A rising x and a y over the same parameter, segment by segment; slope before the first and after the last."""

    x: tuple[Rise, ...]
    y: tuple[Rise, ...]
    before: Number
    after: Number

    def __call__(self, x: ca.SX) -> ca.SX:
        """Y at x."""
        return _follow(x, self.x, self.y, self.before, self.after)

    def inverse(self, y: ca.SX, beta: Number = 0.0) -> ca.SX:
        """The x with y(x) + βx = y, for a y that rises; where the curve begins flat, its beginning for all below."""
        # y + βx is as much a Bézier curve as y
        sheared = [_sum(ys, xs, beta) for xs, ys in zip(self.x, self.y, strict=True)]
        before, after = self.before + beta, self.after + beta
        flat = isinstance(before, float) and before == 0
        return _follow(y, sheared, self.x, 0.0 if flat else 1 / ca.fmax(before, _TINY), 1 / ca.fmax(after, _TINY))


def through(knots: Sequence[Knot], curviness: Sequence[float]) -> Bezier:
    """One corner between each two neighbours; curviness 0 … 1 says how closely it follows its two tangents."""
    x, y = [], []
    for a, b, share in zip(knots[:-1], knots[1:], curviness, strict=True):
        # control points go this part of the way to where the tangents meet
        c = 0.1 + 0.8 * share
        # x_c = (y₁ − y₀ − x₁y₁′ + x₀y₀′)/(y₀′ − y₁′), from x₀
        run = b.x - a.x
        first = c * (b.y - a.y - run * b.slope) / (a.slope - b.slope)
        last = c * run - first
        x.append((a.x, first, run - first - last, last))
        rise = b.y - a.y
        y.append((a.y, first * a.slope, rise - first * a.slope - last * b.slope, last * b.slope))
    return Bezier(tuple(x), tuple(y), knots[0].slope, knots[-1].slope)


def _follow(value: ca.SX, along: Sequence[Rise], across: Sequence[Rise], before: Number, after: Number) -> ca.SX:
    """`across` where `along` has the value; straight with the slopes given before and after."""
    first, last = along[0][0], sum(along[-1])
    inside = clamp(value, first, last)
    beyond = [inside >= rise[0] for rise in along[1:]]
    start, *steps = chosen(along, beyond)
    t = _parameter(inside - start, steps)
    y0, *rises = chosen(across, beyond)
    return y0 + _point(rises, t) + before * ca.fmin(value - first, 0) + after * ca.fmax(value - last, 0)


def _sum(y: Rise, x: Rise, beta: Number) -> Rise:
    a, b, c, d = (v + beta * w for v, w in zip(y, x, strict=True))
    return a, b, c, d


def _parameter(target: ca.SX, steps: Sequence[ca.SX]) -> ca.SX:
    """The t in [0, 1] at which a coordinate has risen by `target`."""
    d1, d2, d3 = steps
    c1, c2, c3, c4, c5 = _powers(steps)
    line = target / (d1 + d2 + d3)
    # a segment that begins flat is 10 d₂t³ there
    flat = (d1 <= 0) * (ca.fmax(target, _TINY) / (10 * d2)) ** (1 / 3)
    t = ca.fmin(1, ca.fmax(line, flat))
    for step in range(_HALLEY_STEPS):
        q = t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5)))) - target
        dq = c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4 + t * 5 * c5)))
        half = c2 + t * (3 * c3 + t * (6 * c4 + t * 10 * c5))
        # t ← t − q q′/(q′² − q q″/2)   Halley
        t = t - q * dq / (dq**2 - q * half)
        if step < _HALLEY_STEPS - 1:  # the last one keeps its derivative at the ends
            t = clamp(t, 0, 1)
    return t


def _point(steps: Sequence[ca.SX], t: ca.SX) -> ca.SX:
    c1, c2, c3, c4, c5 = _powers(steps)
    return t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5))))


def _powers(steps: Sequence[ca.SX]) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX, ca.SX]:
    """The coefficients of t … t⁵; control points 1 and 2 are one, as are 3 and 4."""
    d1, d2, d3 = steps
    # d₁(1 − (1 − t)⁵) + d₂t³(10 − 15t + 6t²) + d₃t⁵: Bernstein's polynomials added from above
    return 5 * d1, -10 * d1, 10 * (d1 + d2), -5 * d1 - 15 * d2, d1 + 6 * d2 + d3
