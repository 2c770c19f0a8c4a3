"""The Kalman filter: position and forces with known noise, inputs that white noise drives; tells how sure it is."""

from __future__ import annotations

import casadi as ca

from ...model.block import Block, Parameter, Parameters, Symbols, symbols
from ...model.skeleton import MASS
from ..observer import Observer, no_rates
from ..ports import ESTIMATES, SENSED
from ..slopes import SLOPES
from ..spread import COVARIANCES
from .motion import Motion
from .parameters import CHOSEN, INPUTS, NOISE, driven, gains
from .states import ENTRIES, INDEX, MEAN, QUANTITIES, covariance, scalars
from .update import measured, predicted

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
# what the last sample leaves for the straight lines to the next
_LAST = ("t", "acc", "L_S1", "L_S2", *SLOPES)


def kalman() -> Block:
    """Inputs t, y1, y2, y3, L_S1, L_S2 and the tendons' slopes; moves at samples only.

    States: 13 means, the 91 entries of their covariance, what was measured last.
    """
    mean, entries, last = symbols(MEAN), symbols(ENTRIES), symbols(f"last.{name}" for name in _LAST)
    u, p = symbols(["t", *SENSED, *SLOPES]), symbols(PARAMETERS)
    was, now = last.part("last"), Symbols({**u, "acc": (u.y3 - u.y2) / p.m})

    # straight lines from sample to sample; the slopes are those in the middle
    T = u.t - was.t
    motion = Motion((was.slope1 + u.slope1) / 2, (was.slope2 + u.slope2) / 2, p.m, T)

    def known(at: Symbols) -> ca.SX:
        """The part of ẋ₂ that is measured."""
        # acc − (p₂z₂ − p₁z₁)/m
        return at.acc - (motion.pull2 * at.L_S2 - motion.pull1 * at.L_S1)

    C, B = motion.factors()
    # x⁻ = e^{AT} x + …
    x = C @ (B @ mean.vector()) + motion.driven(known(was), known(now))
    P = predicted(covariance(entries), (C, B), ca.diag(_densities(p)) * T)
    for name, value, R in _measurements(u, p):
        x, P = measured(x, P, INDEX[name], value, R)
    return Block(
        "kalman",
        x=Symbols({**mean, **entries, **last}),
        u=u,
        p=p,
        parameters=PARAMETERS,
        next=Symbols({**dict(zip(MEAN, ca.vertsplit(x), strict=True)), **scalars(P), **_kept(now)}),
        x0=Symbols(x1_hat=u.y1, x3_hat=u.L_S1, x4_hat=u.L_S2, **scalars(ca.diag(_start(u, p))), **_kept(now)),
        y=Symbols({**mean.only(ESTIMATES), **entries.only(COVARIANCES)}),
    )


def _kept(now: Symbols) -> Symbols:
    return Symbols({f"last.{name}": now[name] for name in _LAST})


def _measurements(u: Symbols, p: Symbols) -> list[tuple[str, ca.SX, ca.SX]]:
    """State, what is measured of it, variance of the noise."""
    # R₁ = σ₁²,  R_j = (σ_Fj/p_j)²
    return [
        ("x1", u.y1, p.sigma_1**2),
        ("x3", u.L_S1, (p.sigma_F1 / u.slope1) ** 2),
        ("x4", u.L_S2, (p.sigma_F2 / u.slope2) ** 2),
    ]


def _densities(p: Symbols) -> ca.SX:
    """The diagonal of Q (n × 1): the last derivative in use of each input is driven."""
    Q = ca.SX(len(QUANTITIES), 1)
    for chain, order, s in driven(p):
        for i, name in enumerate(chain, start=1):
            Q[INDEX[name]] = s**2 * (order == i)
    return Q


def _start(u: Symbols, p: Symbols) -> ca.SX:
    """The variances (n × 1) at the start; a derivative that is not in use is known to be 0."""
    variance = {name: p.start_sigma**2 * R for name, _, R in _measurements(u, p)} | {"x2": p.start_x2**2}
    for (chain, order, _), sd in zip(driven(p), (p.start_D, p.start_u, p.start_u), strict=True):
        for i, name in enumerate(chain):
            variance[name] = (sd * p.start_rate**i) ** 2 * (order > i)
    return ca.vertcat(*(variance[name] for name in QUANTITIES))


KALMAN = Observer("KF", kalman, gains=gains, rates=no_rates)
