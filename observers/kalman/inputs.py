"""The model of the first pass: unknown inputs Δ_Φ, u₁ and u₂ are chains of integrators that white noise drives."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from ...model.block import Parameter, Parameters, Symbols
from ...model.skeleton.load import MASS
from ..behind.spread import COVARIANCES
from ..ports import ESTIMATES
from ..slopes import SLOPES
from ..tendons import LENGTHS
from .chains import Chain, known_acceleration, last_in_use, start
from .model import Measurement, Model, Move
from .motion import Motion
from .parameters import CHOSEN, INPUTS, NOISE
from .states import CHAINS, INDEX, MEAN, QUANTITIES, scalars

PARAMETERS: Parameters = {
    **NOISE,
    **INPUTS,
    "start_sigma": Parameter(2.0, "sd of x̂₁, x̂₃, x̂₄ at the start, in that of their noise", CHOSEN, above=0),
    "start_x2": Parameter(0.3, "sd of x̂₂ at the start", CHOSEN, above=0),
    "start_D": Parameter(0.5, "sd of Δ̂ at the start", CHOSEN, above=0),
    "start_u": Parameter(0.3, "sd of û₁ and û₂ at the start", CHOSEN, above=0),
    "start_rate": Parameter(3.0, "sd of a derivative at the start, in that of the one before", CHOSEN, above=0),
    "m": MASS,
}
# what is known at a sample; acc = R y/m is what the measured forces do to the mass
SAMPLE = ("t", "y1", "acc", *LENGTHS, *SLOPES)


def _move(was: Symbols, now: Symbols, p: Symbols) -> Move:
    """The motion between two samples."""
    # straight lines from sample to sample; the slopes are those in the middle
    T = now.t - was.t
    motion = Motion((was.slope1 + now.slope1) / 2, (was.slope2 + now.slope2) / 2, p.m, T)

    ends = (known_acceleration(at, motion.pull1, motion.pull2) for at in (was, now))
    return Move(motion.factors(), motion.driven(*ends), T, ca.SX(len(INDEX), 1))


def measurements(u: Symbols, p: Symbols, index: Mapping[str, int] = INDEX) -> list[Measurement]:
    """Position, and the forces as lengths of the tendons."""
    # R₁ = σ₁²,  R_j = (σ_Fj/p_j)²
    return [
        Measurement(index["x1"], u.y1, p.sigma_1**2),
        Measurement(index["x3"], u.L_S1, (p.sigma_F1 / u.slope1) ** 2),
        Measurement(index["x4"], u.L_S2, (p.sigma_F2 / u.slope2) ** 2),
    ]


def _start(u: Symbols, p: Symbols) -> tuple[ca.SX, ca.SX]:
    return start(measurements(u, p), zip(_orders(p), (p.start_D, p.start_u, p.start_u), strict=True), p, INDEX)


def _orders(p: Symbols) -> list[Chain]:
    return list(zip(CHAINS.values(), (p.order_D, p.order_u, p.order_u), strict=True))


def _noise(p: Symbols) -> Mapping[str, ca.SX]:
    return dict(zip(DENSITIES, (last_in_use(chain, INDEX) for chain in _orders(p)), strict=True))


def _told(mean: ca.SX, P: ca.SX, now: Symbols) -> Symbols:
    """The estimates, and the covariances that their standard deviations follow from."""
    means = Symbols(zip(MEAN, ca.vertsplit(mean), strict=True))
    return Symbols({**means.only(ESTIMATES), **scalars(P).only(COVARIANCES)})


DENSITIES = ("s_D", "s_u1", "s_u2")
INPUTS_MODEL = Model(QUANTITIES, SAMPLE, PARAMETERS, _start, _move, _noise, measurements, _told)
