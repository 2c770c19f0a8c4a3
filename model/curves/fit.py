"""From the points of a table to the nodes of a C² curve: a natural cubic spline, kept rising, with few nodes."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from ..arrays import Array
from ..errors import Error
from .spline import MOST_STEPS, Node, Spline, powers

# how closely a table is followed, of its largest value: the first that needs no more pieces than these
_TOLERANCES = (1e-6, 1e-5, 1e-4, 1e-3)
_MOST_PIECES = 64
# slopes where two pieces meet, in those of the straight lines on both sides, so that both pieces rise
_GENTLEST, _STEEPEST = 0.1, 1.25
# an inverse is tried at so many points of each piece, with drags β, until it is exact but for rounding
_SAMPLES, _DRAGS, _EXACT = 33, (0.0, 0.1, 1.0), 1e-14


class TableError(Error, ValueError):
    """A table that makes no curve; the sentence says what is wrong, and where."""


@dataclass(frozen=True)
class Fit:
    """A curve, and by how much it misses the table and the spline through all its points."""

    curve: Spline
    error: float


def fit(x: Array, y: Array, rising: bool = False, foot: bool = False) -> Fit:
    """The curve through a table, x rising. `rising`: y does not fall, and neither will the curve.

    `foot`: the curve has its first value at all smaller x, and begins where the table leaves it. TableError if it
    takes too many pieces.
    """
    if foot:
        # one more point of the flat part: natural ends and limits do the rest
        x, y = np.insert(x, 0, 2 * x[0] - x[1]), np.insert(y, 0, y[0])
    slope, curvature = natural(x, y)
    if rising:
        slope, curvature = _limited(x, y, slope, curvature)
    # a curve that stays flat is one piece all the same
    start = min(np.flatnonzero(y == y[0])[-1], len(y) - 2) if foot else 0
    nodes = [Node(*map(float, numbers)) for numbers in zip(x, y, slope, curvature, strict=True)][start:]
    for tolerance in _TOLERANCES:
        found = _thinned(nodes, tolerance * float(np.abs(y).max()), rising)
        if len(found.curve.nodes) <= _MOST_PIECES + 1:
            return found
    raise TableError(
        f"cannot be followed to {_TOLERANCES[-1]:.1%} with {_MOST_PIECES} pieces: it is too rough; "
        f"smooth it, or give {_MOST_PIECES + 1} points at most"
    )


def invertible(found: Fit) -> Fit:
    """The same with as many steps as the inverse of this rising curve takes, fibre damping included, and one more."""
    y, beta = ca.SX.sym("y"), ca.SX.sym("beta")
    nodes = found.curve.nodes
    places = np.unique(np.concatenate([np.linspace(a.x, b.x, _SAMPLES) for a, b in itertools.pairwise(nodes)]))
    largest = max(abs(node.y) for node in nodes)
    for steps in range(2, MOST_STEPS):
        curve = replace(found.curve, steps=steps)
        x = curve.inverse(y, beta)
        error = ca.Function("error", [y, beta], [ca.fabs(curve(x) + beta * x - y)])
        values = np.array(ca.Function("value", [y], [curve(y)])(places)).ravel()
        if all(np.array(error(values + b * places, b)).max() <= _EXACT * largest for b in _DRAGS):
            return replace(found, curve=replace(curve, steps=steps + 1))
    return found


def natural(x: Array, y: Array) -> tuple[Array, Array]:
    """Slopes and curvatures at the points of the cubic spline without curvature at both ends."""
    h, k = np.diff(x), np.zeros_like(x)
    chord = np.diff(y) / h
    # hᵢ₋₁kᵢ₋₁ + 2(hᵢ₋₁ + hᵢ)kᵢ + hᵢkᵢ₊₁ = 6(sᵢ − sᵢ₋₁), by elimination
    diagonal, right = 2 * (h[:-1] + h[1:]), 6 * np.diff(chord)
    for i in range(1, len(diagonal)):
        share = h[i] / diagonal[i - 1]
        diagonal[i] -= share * h[i]
        right[i] -= share * right[i - 1]
    for i in range(len(diagonal) - 1, -1, -1):
        k[i + 1] = (right[i] - h[i + 1] * k[i + 2]) / diagonal[i]
    slope = np.append(chord - h * (2 * k[:-1] + k[1:]) / 6, chord[-1] + h[-1] * (k[-2] + 2 * k[-1]) / 6)
    return slope, k


def _limited(x: Array, y: Array, slope: Array, curvature: Array) -> tuple[Array, Array]:
    """The same, changed where a piece would fall: until the six Bézier points of each piece rise."""
    # the pieces on both sides; beyond the ends there is a long one of the same slope
    h, rise = np.diff(x), np.diff(y)
    chord, far = rise / h, 1e6 * (x[-1] - x[0])
    left, right = np.append(far, h), np.append(h, far)
    up_left, up_right = np.append(far * chord[0], rise), np.append(rise, far * chord[-1])
    least = np.minimum(up_left / left, up_right / right)
    m = np.clip(slope, _GENTLEST * least, _STEEPEST * least)
    # points 0 … 2 of a piece: y, y + hm/5, y + 2hm/5 + h²k/20; the last one stays below half the rise
    low = np.maximum(-4 * m / right, (8 * left * m - 10 * up_left) / left**2)
    high = np.minimum(4 * m / left, (10 * up_right - 8 * right * m) / right**2)
    return m, np.clip(curvature, low, high)


def _thinned(nodes: list[Node], tolerance: float, rising: bool) -> Fit:
    """Each piece as long as it may be, greedily."""
    kept, error, at = nodes[:1], 0.0, 0
    x, y = (np.array([getattr(node, name) for node in nodes]) for name in ("x", "y"))
    # what lies halfway between the points, on the spline through all of them
    middle = np.array([_at(a, b, (a.x + b.x) / 2) for a, b in itertools.pairwise(nodes)])
    while at < len(nodes) - 1:
        end, missed = at + 1, 0.0
        while end + 1 < len(nodes):
            a, b = nodes[at], nodes[end + 1]
            inner, halves = slice(at + 1, end + 1), slice(at, end + 1)
            between = (x[halves] + x[at + 1 : end + 2]) / 2
            off = [
                np.abs(_at(a, b, place) - value).max()
                for place, value in ((x[inner], y[inner]), (between, middle[halves]))
            ]
            if max(off) > tolerance or (rising and not _rises(a, b)):
                break
            end, missed = end + 1, float(max(off))
        error = max(error, missed)
        kept.append(nodes[end])
        at = end
    return Fit(Spline(tuple(kept)), error)


def _at(a: Node, b: Node, x: float | Array) -> Array:
    """The piece from a to b at x."""
    return np.asarray(a.y + np.polyval((*powers(a, b)[::-1], 0.0), (x - a.x) / (b.x - a.x)), dtype=np.float64)


def _rises(a: Node, b: Node) -> bool:
    """Whether the Bézier points of the piece do, which is enough."""
    h = b.x - a.x
    points = (
        a.y,
        a.y + h * a.slope / 5,
        a.y + 2 * h * a.slope / 5 + h**2 * a.curvature / 20,
        b.y - 2 * h * b.slope / 5 + h**2 * b.curvature / 20,
        b.y - h * b.slope / 5,
        b.y,
    )
    return all(p <= q for p, q in itertools.pairwise(points))
