"""C² curves of quintic pieces, each known by value, slope and curvature at both ends; straight beyond the ends."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from ..dialect import chosen, clamp

Number = ca.SX | float

# steps that find a point of the worst rising piece to the last bits; most curves need three
MOST_STEPS = 13
# where rounding alone decides, the bracket does not
_SLACK = 1e-9
# keeps the cube root's derivative finite at the beginning, and 0/0 out of the steps
_TINY = 1e-45


@dataclass(frozen=True)
class Node:
    """A point of the curve, its slope and its curvature (second derivative) there."""

    x: float
    y: float
    slope: float
    curvature: float


@dataclass(frozen=True)
class Spline:
    """The curve through its nodes, x rising; its inverse takes so many `steps`."""

    nodes: tuple[Node, ...]
    steps: int = MOST_STEPS

    def __call__(self, x: ca.SX) -> ca.SX:
        """Y at x."""
        first, last = self.nodes[0], self.nodes[-1]
        inside = clamp(x, first.x, last.x)
        rows = [(a.x, 1 / (b.x - a.x), a.y, *powers(a, b)) for a, b in itertools.pairwise(self.nodes)]
        start, per_width, y, *c = chosen(rows, [inside >= node.x for node in self.nodes[1:-1]])
        line = first.slope * ca.fmin(x - first.x, 0) + last.slope * ca.fmax(x - last.x, 0)
        return y + _polynomial(c, (inside - start) * per_width) + line

    def inverse(self, y: ca.SX, beta: Number = 0.0) -> ca.SX:
        """The x with y(x) + βx = y, for a y that rises; where the curve begins flat, its beginning for all below."""
        # y + βx is as much a curve of such pieces as y
        ys = [node.y + beta * node.x for node in self.nodes]
        inside = clamp(y, ys[0], ys[-1])
        rows = []
        for (a, b), (low, high) in zip(itertools.pairwise(self.nodes), itertools.pairwise(ys), strict=True):
            first, *others = powers(a, b)
            rows.append((low, 1 / (high - low), a.x, b.x - a.x, first + beta * (b.x - a.x), *others))
        start, per_rise, x, width, *c = chosen(rows, [inside >= value for value in ys[1:-1]])
        t = _parameter(inside - start, per_rise, c, self.steps)
        before, after = self.nodes[0].slope + beta, self.nodes[-1].slope + beta
        flat = isinstance(before, float) and before == 0
        line = ca.fmax(y - ys[-1], 0) / ca.fmax(after, _TINY)
        return x + width * t + (line if flat else line + ca.fmin(y - ys[0], 0) / ca.fmax(before, _TINY))


def powers(a: Node, b: Node) -> tuple[float, float, float, float, float]:
    """The coefficients of t … t⁵ from node a to node b, t in [0, 1]."""
    width = b.x - a.x
    rise, m0, m1 = b.y - a.y, width * a.slope, width * b.slope
    k0, k1 = width**2 * a.curvature / 2, width**2 * b.curvature / 2
    # Hermite's quintic: value, slope and curvature at both ends
    return (
        m0,
        k0,
        10 * rise - 6 * m0 - 4 * m1 - 3 * k0 + k1,
        -15 * rise + 8 * m0 + 7 * m1 + 3 * k0 - 2 * k1,
        6 * rise - 3 * (m0 + m1) - k0 + k1,
    )


def _polynomial(c: Sequence[ca.SX], t: ca.SX) -> ca.SX:
    """c₁t + … + c₅t⁵."""
    c1, c2, c3, c4, c5 = c
    return t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5))))


def _parameter(target: ca.SX, per_rise: ca.SX, c: Sequence[ca.SX], steps: int) -> ca.SX:
    """The t in [0, 1] at which the rising piece c₁t + … has risen by `target`."""
    # a piece that begins flat is c₃t³ there
    flat = (c[0] <= 0) * (ca.fmax(target, _TINY) / ca.fmax(c[2], _TINY)) ** (1 / 3)
    t = ca.fmin(1, ca.fmax(target * per_rise, flat))
    low, high = ca.SX(0), ca.SX(1)
    for _ in range(steps - 1):
        q, found = _step(c, t, target)
        # the root stays between; a step that would leave halves
        low, high = ca.fmax(low, t * (q < 0)), ca.fmin(high, ca.fmax(t, q <= 0))
        middle = (low + high) / 2
        within = ca.logic_and(found >= low * (1 - _SLACK), found <= high * (1 + _SLACK))
        t = middle + within * (found - middle)
    # the last one keeps its derivative at the ends
    return _step(c, t, target)[1]


def _step(c: Sequence[ca.SX], t: ca.SX, target: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The error at t, and a better t."""
    c1, c2, c3, c4, c5 = c
    q = _polynomial(c, t) - target
    dq = c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4 + t * 5 * c5)))
    half = c2 + t * (3 * c3 + t * (6 * c4 + t * 10 * c5))
    # t ← t − q q′/(q′² − q q″/2)   Halley, at most twice Newton's step
    return q, t - q * dq / ca.fmax(dq**2 - q * half, dq**2 / 2)
