"""The models of a joint and of a muscle alone: chains of integrators whose first is measured, whose last is noise.

With the forces measured nothing else couples them: q̈ = α + ν + Δ with a known α, L̇_S = L̇_m + u with a known L̇_m. The
names are those that a joint has for the mass, and a muscle for muscle 1.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence

import casadi as ca

from ....model.block import Parameters, Symbols
from ...behind.spread import entry
from ..chains import last_in_use, start
from ..inputs import PARAMETERS as OF_THE_PAIR
from ..model import Measurement, Model, Move
from ..states import CHAINS

# of a joint: q, q̇, and what noise of the forces leaves in α where it lasts
OF_JOINT = ("x1", "x2", "nu", *CHAINS["Delta"])
# of a muscle: L_S
OF_MUSCLE = ("x3", *CHAINS["u1"])

# noise, √density and order, then with what it starts
JOINT: Parameters = {
    name: OF_THE_PAIR[name]
    for name in ("sigma_1", "s_D", "order_D", "start_sigma", "start_x2", "start_D", "start_rate")
}
MUSCLE: Parameters = {
    name: OF_THE_PAIR[name] for name in ("sigma_F1", "s_u1", "order_u", "start_sigma", "start_u", "start_rate")
}


def index_of(names: Sequence[str]) -> Mapping[str, int]:
    """The place of each."""
    return {name: i for i, name in enumerate(names)}


def _integrated(chains: Sequence[Sequence[str]], index: Mapping[str, int], T: ca.SX) -> ca.SX:
    """e^{AT} of chains of integrators: each state has what its successors become in T."""
    F = ca.SX.eye(len(index))
    for chain in chains:
        for (i, name), (j, after) in itertools.combinations(enumerate(chain), 2):
            F[index[name], index[after]] = T ** (j - i) / math.factorial(j - i)
    return F


def told_of(names: Sequence[str], index: Mapping[str, int], mean: ca.SX, P: ca.SX) -> Symbols:
    """The means of these states, and all their covariances."""
    means = {name: mean[index[name]] for name in names}
    pairs = itertools.combinations_with_replacement(names, 2)
    return Symbols({**means, **{entry(a, b): P[index[a], index[b]] for a, b in pairs}})


def _joint() -> Model:
    index = index_of(OF_JOINT)
    x1, x2, nu = (index[name] for name in OF_JOINT[:3])

    def chain(p: Symbols) -> tuple[tuple[str, ...], ca.SX]:
        return CHAINS["Delta"], p.order_D

    def move(was: Symbols, now: Symbols, p: Symbols) -> Move:
        T, w = now.t - was.t, (was.pole + now.pole) / 2
        F, b, Q = _integrated([("x1", "x2", *CHAINS["Delta"])], index, T), ca.SX(len(index), 1), ca.SX(len(index), 1)
        # ν̇ = −wν + noise
        left = ca.exp(-w * T)
        F[nu, nu], F[x2, nu], F[x1, nu] = left, (1 - left) / w, (T - (1 - left) / w) / w
        # α goes in a straight line
        rise = now.acc - was.acc
        b[x2], b[x1] = T * (was.acc + rise / 2), T**2 * (was.acc / 2 + rise / 6)
        # white noise of this density in α, and low-passed noise of that one
        Q[x2], Q[nu] = (was.white + now.white) / 2, w**2 * (was.lasting + now.lasting) / 2
        return Move([F], b, T, Q)

    def measurements(now: Symbols, p: Symbols) -> list[Measurement]:
        return [Measurement(x1, now.y, p.sigma_1**2)]

    def begun(now: Symbols, p: Symbols) -> tuple[ca.SX, ca.SX]:
        mean, variance = start(measurements(now, p), [(chain(p), p.start_D)], p, index)
        # that which stays as large as it is
        variance[nu] = now.pole * now.lasting / 2
        return mean, variance

    return Model(
        OF_JOINT,
        ("t", "y", "acc", "white", "lasting", "pole"),
        JOINT,
        begun,
        move,
        lambda p: {"s_D": last_in_use(chain(p), index)},
        measurements,
        lambda mean, P, now: told_of(("x1", "x2", "Delta"), index, mean, P),
    )


def _muscle() -> Model:
    index = index_of(OF_MUSCLE)
    x3 = index["x3"]

    def chain(p: Symbols) -> tuple[tuple[str, ...], ca.SX]:
        return CHAINS["u1"], p.order_u

    def move(was: Symbols, now: Symbols, p: Symbols) -> Move:
        T, b = now.t - was.t, ca.SX(len(index), 1)
        # L̇_S = L̇_m + u, the first in a straight line
        b[x3] = T * (was.rate + now.rate) / 2
        return Move([_integrated([OF_MUSCLE], index, T)], b, T, ca.SX(len(index), 1))

    def measurements(now: Symbols, p: Symbols) -> list[Measurement]:
        # R = (σ_F/p)²
        return [Measurement(x3, now.z, (p.sigma_F1 / now.slope) ** 2)]

    return Model(
        OF_MUSCLE,
        ("t", "z", "slope", "rate"),
        MUSCLE,
        lambda now, p: start(measurements(now, p), [(chain(p), p.start_u)], p, index),
        move,
        lambda p: {"s_u1": last_in_use(chain(p), index)},
        measurements,
        lambda mean, P, now: told_of(("x3", "u1"), index, mean, P),
    )


JOINT_MODEL, MUSCLE_MODEL = _joint(), _muscle()
