"""Curves given as tables: four of them, in a muscle's own units, become a CurveSet. Strains are in the tables."""

from __future__ import annotations

import functools
import hashlib
from dataclasses import dataclass, fields, replace

import casadi as ca
import numpy as np

from ..arrays import Array
from .curve_set import CurveSet
from .fit import Fit, TableError, fit, invertible
from .normalised import fibre_numbers, normalised, tendon_numbers
from .spline import Spline

# x and y, point by point
Points = tuple[tuple[float, float], ...]

_SOURCE = "docs/curves.md"
_LEAST_POINTS, MOST_POINTS = 4, 5_000
# beyond these, in own units, numbers have other units, or a curve has a step
_LARGEST, _STEEPEST = 20.0, 10_000.0
# own units say where some curves are 0 or 1; tables of other units miss it by more
_UNIT_ERROR = 0.02
# a tendon's slack length in itself, the length of the largest force in itself
_NEAR_SLACK, _NEAR_OPTIMAL = 0.1, 0.2


@dataclass(frozen=True)
class Tables:
    """Points (x, y) in own units: forces in F0, lengths in l0 and l_T, velocities in l0·v_max, > 0 when lengthening."""

    tendon_force_length: Points
    passive_force_length: Points
    active_force_length: Points
    force_velocity: Points


TABLES = tuple(field.name for field in fields(Tables))


# equal tables are one set, and so one compiled library
@functools.lru_cache(maxsize=32)
def tabulated(tables: Tables) -> CurveSet:
    """The curves through four tables, C², straight beyond them. TableError names the table and says what is wrong.

    The tendon is slack, and the passive force constant, before the table. The curves miss the points by 10⁻⁶ of the
    largest value at most, by more if 64 pieces do not suffice; `sentence` tells by how much.
    """
    tendon, passive, active, velocity = (_fitted(name, getattr(tables, name)) for name in TABLES)
    found = {"tendon": tendon, "passive": passive, "active": active, "velocity": velocity}
    points = sum(len(getattr(tables, name)) for name in TABLES)
    pieces = sum(len(one.curve.nodes) - 1 for one in found.values())
    errors = ", ".join(f"{name} {one.error:.1g}" for name, one in found.items())
    fT, fP, fL, fV = (one.curve for one in found.values())
    curve_set = normalised(
        name=f"tables@{hashlib.sha256(repr(tables).encode()).hexdigest()[:12]}",
        sentence=f"{pieces} pieces through {points:,} points of four tables; largest errors: {errors}",
        source="tables of a user",
        tendon={key: number for key, number in tendon_numbers(0.0, _SOURCE).items() if key != "tendon_strain"},
        fibre={key: number for key, number in fibre_numbers(0.0, _SOURCE).items() if key != "passive_strain"},
        fT=lambda length, p: fT(length),
        fT_inv=lambda force, p: fT.inverse(force),
        fP=lambda length, p: fP(length),
        fL=lambda length, p: fL(length),
        fV=lambda v, p: fV(v),
        fV_inv=lambda factor, beta, p: fV.inverse(factor, beta),
        toe_force=fT.nodes[-1].y,
    )
    return replace(curve_set, tables={name: getattr(tables, name) for name in TABLES})


def _fitted(name: str, points: Points) -> Fit:
    try:
        return _CURVES[name](*_checked(points))
    except TableError as error:
        raise TableError(f"{name}: {error}") from error


def _checked(points: Points) -> tuple[Array, Array]:
    if not _LEAST_POINTS <= len(points) <= MOST_POINTS:
        raise TableError(f"has {len(points):,} points; a curve needs {_LEAST_POINTS} to {MOST_POINTS:,}")
    x, y = np.array(points, dtype=float).T
    if wrong := np.flatnonzero(~((np.abs(x) <= _LARGEST) & (np.abs(y) <= _LARGEST))).tolist():
        at = wrong[0]
        raise TableError(
            f"point {at + 1}, ({x[at]:.6g}, {y[at]:.6g}), must be two numbers within ±{_LARGEST:g}: "
            "tables are in a muscle's own units"
        )
    if wrong := np.flatnonzero(np.diff(x) <= 0).tolist():
        at = wrong[0]
        raise TableError(f"x must rise from point to point, and point {at + 2} has {x[at + 1]:.9g} after {x[at]:.9g}")
    if wrong := np.flatnonzero(np.abs(np.diff(y)) > _STEEPEST * np.diff(x)).tolist():
        at = wrong[0]
        raise TableError(f"has a step from {y[at]:.6g} to {y[at + 1]:.6g} at x = {x[at]:.9g}, point {at + 1}")
    return x, y


def _tendon(x: Array, y: Array) -> Fit:
    if y[0] != 0:
        raise TableError(f"must begin with force 0, where the tendon is slack, not {y[0]:.6g}")
    slack = max(int(np.argmax(y != 0)) - 1, 0)
    _refuse_falling(x[slack:], y[slack:], slack, strictly=True)
    if abs(x[slack] - 1) > _NEAR_SLACK:
        raise TableError(
            f"the force begins at {x[slack]:.6g}, and must at 1: x is the tendon's length in its slack length"
        )
    return invertible(fit(x, y, rising=True, foot=True))


def _passive(x: Array, y: Array) -> Fit:
    _refuse_falling(x, y, 0, strictly=False)
    if y[0] < 0:
        raise TableError(f"a passive force must not be below 0; the first is {y[0]:.6g}")
    return fit(x, y, rising=True, foot=True)


def _active(x: Array, y: Array) -> Fit:
    low = int(y.argmin())
    if y[low] < 0:
        raise TableError(f"a force-length factor must not be below 0; point {low + 1} is {y[low]:.6g}")
    top = int(y.argmax())
    if abs(y[top] - 1) > _UNIT_ERROR or abs(x[top] - 1) > _NEAR_OPTIMAL:
        raise TableError(f"its largest factor must be 1 at the length 1, and is {y[top]:.6g} at {x[top]:.6g}")
    return fit(x, y)


def _velocity(x: Array, y: Array) -> Fit:
    _refuse_falling(x, y, 0, strictly=True)
    if x[0] > -1 or x[-1] < 0:
        raise TableError(f"must reach from −1 to 0 and beyond, not from {x[0]:.6g} to {x[-1]:.6g}")
    found = fit(x, y, rising=True)
    for v, factor in ((-1.0, 0), (0.0, 1)):
        if abs((value := _value(found.curve, v)) - factor) > _UNIT_ERROR:
            raise TableError(f"its factor must be {factor} at the velocity {v:g}, and is {value:.6g}")
    return invertible(found)


_CURVES = dict(zip(TABLES, (_tendon, _passive, _active, _velocity), strict=True))


def _refuse_falling(x: Array, y: Array, before: int, strictly: bool) -> None:
    wrong = np.diff(y) <= 0 if strictly else np.diff(y) < 0
    if at := np.flatnonzero(wrong)[:1].tolist():
        here, point = at[0], before + at[0] + 2
        must = "rise from point to point" if strictly else "never fall"
        raise TableError(
            f"y must {must}, and point {point} (x = {x[here + 1]:.6g}) has {y[here + 1]:.9g} after {y[here]:.9g}"
        )


def _value(curve: Spline, x: float) -> float:
    return float(ca.DM(curve(ca.SX(x))))
