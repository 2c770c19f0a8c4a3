"""The model of a muscle alone in the second pass: its activation is a chain of integrators, Hill's law gives the input.

The law is linear about the estimates of the first pass, as that of the pair: ../activations.py.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import casadi as ca

from ....model.block import Block, Parameters, Symbols, symbols
from ....model.dialect import clamp
from ....model.symbols import hat
from ....model.system import System
from ...behind.activation import activation_parameters, formulas
from ..activations import CHAINS, FASTEST, LEAST_SLOPE, SLOWEST
from ..activations import PARAMETERS as OF_THE_PAIR
from ..chains import last_in_use, start
from ..exponential import driven
from ..model import Model, Move
from .integrators import MUSCLE, MUSCLE_MODEL, index_of, told_of

OF_LAW = ("s_x3",)
QUANTITIES = ("x3", *CHAINS["a1"])
_INDEX = index_of(QUANTITIES)
_N = len(QUANTITIES)
# about which the law is linear: velocity, slopes, estimates
LINE = ("u", "b_x3", "b_a", "x3_hat", "a_hat")

LAW: Parameters = {
    "sigma_F1": MUSCLE["sigma_F1"],
    **{name: OF_THE_PAIR[name] for name in ("s_a1", "order_a", "s_x3", "start_sigma", "start_a", "start_rate")},
}


def linear_law(system: System) -> Block:
    """Inputs: the estimates; outputs: of each muscle `BRA.u`, `BRA.b_x3`, `BRA.b_a` and `BRA.a_hat`, not limited."""
    u, parameters = symbols(system.estimates), activation_parameters(system)
    p, y = symbols(parameters), Symbols()
    for f in formulas(system, u, p):
        L_S, u_hat = (hat(system.name(signal, f.muscle)) for signal in ("L_S", "u"))
        drive = clamp(u[u_hat], SLOWEST * f.speed, FASTEST * f.speed)
        slopes = ca.substitute(ca.jacobian(f.a, ca.vertcat(u[L_S], f.drive)), f.drive, drive)
        # u − û = b (L_S − L̂_S, a − â),  b = (−∂a/∂L_S, 1)/(∂a/∂u)
        steepness = ca.fmax(slopes[1], LEAST_SLOPE)
        values = (drive, -slopes[0] / steepness, 1 / steepness, ca.substitute(f.a, f.drive, drive))
        y |= {f"{f.muscle}.{name}": value for name, value in zip(("u", "b_x3", "b_a", "a_hat"), values, strict=True)}
    return Block("linear_law", u=u, p=p, parameters=parameters, y=y)


def _move(was: Symbols, now: Symbols, p: Symbols) -> Move:
    T = now.t - was.t
    # the same slopes at both ends
    b_x3, b_a = (was.b_x3 + now.b_x3) / 2, (was.b_a + now.b_a) / 2
    x3, a = _INDEX["x3"], _INDEX["a1"]
    A, before, after = ca.SX(_N, _N), ca.SX(_N, 1), ca.SX(_N, 1)
    # L̇_S = L̇_m + û + b_x3 (L_S − L̂_S) + b_a (a − â)
    A[x3, x3], A[x3, a] = b_x3, b_a
    for w, at in ((before, was), (after, now)):
        w[x3] = at.rate + at.u - b_x3 * at.x3_hat - b_a * at.a_hat
    for name, rate in itertools.pairwise(CHAINS["a1"]):
        A[_INDEX[name], _INDEX[rate]] = 1
    F, b = driven(A, before, after, T)
    return Move([F], b, T, ca.SX(_N, 1))


def _start(now: Symbols, p: Symbols) -> tuple[ca.SX, ca.SX]:
    chain = CHAINS["a1"], p.order_a
    mean, variance = start(MUSCLE_MODEL.measurements(now, p), [(chain, p.start_a)], p, _INDEX)
    mean[_INDEX["a1"]] = clamp(now.a_hat, 0, 1)
    return mean, variance


def _noise(p: Symbols) -> Mapping[str, ca.SX]:
    return {
        "s_a1": last_in_use((CHAINS["a1"], p.order_a), _INDEX),
        "s_x3": ca.SX.eye(_N)[:, _INDEX["x3"]],
    }


def _told(mean: ca.SX, P: ca.SX, now: Symbols) -> Symbols:
    """The tendon's length and the activation, not limited, with all their covariances, and the slope of u in a.

    û stays that of the first pass: here it would be the error of a length times the slope of a stiff tendon.
    """
    return Symbols({**told_of(("x3", "a1"), _INDEX, mean, P), "b_a": now.b_a})


LAW_MODEL = Model(
    QUANTITIES, (*MUSCLE_MODEL.inputs, *LINE), LAW, _start, _move, _noise, MUSCLE_MODEL.measurements, _told
)
