"""The Kalman filter: position and forces with known noise, inputs that white noise drives; tells how sure it is."""

from __future__ import annotations

import math
from collections.abc import Mapping

import casadi as ca

from ...model.block import Block, Parameter, Symbols, symbols
from ...model.skeleton import MASS
from ...model.symbols import hat
from ..observer import Observer, Sizes
from ..ports import ESTIMATES, SENSED
from ..slopes import SLOPES
from ..spread import COVARIANCES
from .motion import Motion
from .states import CHAINS, ENTRIES, INDEX, LONGEST, MEAN, QUANTITIES, covariance, scalars
from .update import measured, predicted

_CHOSEN = "chosen, docs/observers.md#kalman"
# of uniform noise within ±w: w/√3
_PAPER_NOISE, _FROM_BOUNDS = 1e-3 / math.sqrt(3), "paper, §V: uniform within ±0.001"

PARAMETERS = {
    "sigma_1": Parameter(_PAPER_NOISE, "standard deviation of the noise of y₁", _FROM_BOUNDS, above=0),
    "sigma_F1": Parameter(_PAPER_NOISE, "standard deviation of the noise of y₂", _FROM_BOUNDS, above=0),
    "sigma_F2": Parameter(_PAPER_NOISE, "standard deviation of the noise of y₃", _FROM_BOUNDS, above=0),
    "s_D": Parameter(2.37e-3, "√ of the density of the white noise that drives Δ_Φ", _CHOSEN, least=0),
    "s_u1": Parameter(4.34e-3, "√ of the density of the white noise that drives u₁", _CHOSEN, least=0),
    "s_u2": Parameter(4.34e-3, "√ of the density of the white noise that drives u₂", _CHOSEN, least=0),
    "order_D": Parameter(2, "which derivative of Δ_Φ is white noise", _CHOSEN, least=1, most=LONGEST),
    "order_u": Parameter(2, "which derivative of u₁ and u₂ is white noise", _CHOSEN, least=1, most=LONGEST),
    "start_sigma": Parameter(2.0, "sd of x̂₁, x̂₃, x̂₄ at the start, in that of their noise", _CHOSEN, above=0),
    "start_x2": Parameter(0.3, "standard deviation of x̂₂ at the start", _CHOSEN, above=0),
    "start_D": Parameter(0.5, "standard deviation of Δ̂ at the start", _CHOSEN, above=0),
    "start_u": Parameter(0.3, "standard deviation of û₁, û₂ at the start", _CHOSEN, above=0),
    "start_rate": Parameter(3.0, "standard deviation of a derivative at the start, in that of the one before", _CHOSEN, above=0),
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

    F = motion.matrix()
    # x⁻ = F x + …,  P⁻ = F(P + QT/2)Fᵀ + QT/2
    x = F @ mean.vector() + motion.driven(known(was), known(now))
    P = predicted(covariance(entries), F, ca.diag(_densities(p)) * T)
    for name, value, R in _measurements(u, p):
        x, P = measured(x, P, INDEX[name], value, R)
    return Block(
        "kalman",
        x=Symbols({**mean, **entries, **last}),
        u=u,
        p=p,
        parameters=PARAMETERS,
        next=Symbols({**dict(zip(MEAN, ca.vertsplit(x), strict=True)), **scalars(P), **_kept(now)}),
        x0=Symbols(
            x1_hat=u.y1, x3_hat=u.L_S1, x4_hat=u.L_S2, **scalars(ca.diag(_start(u, p))), **_kept(now)
        ),
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


def _orders(p: Symbols) -> dict[str, ca.SX]:
    return {"Delta": p.order_D, "u1": p.order_u, "u2": p.order_u}


def _densities(p: Symbols) -> ca.SX:
    """The diagonal of Q (n × 1): the last derivative in use of each input is driven."""
    Q = ca.SX(len(QUANTITIES), 1)
    for (chain, order), s in zip(_orders(p).items(), (p.s_D, p.s_u1, p.s_u2), strict=True):
        for i, name in enumerate(CHAINS[chain], start=1):
            Q[INDEX[name]] = s**2 * (order == i)
    return Q


def _start(u: Symbols, p: Symbols) -> ca.SX:
    """The variances (n × 1) at the start; a derivative that is not in use is known to be 0."""
    variance = {name: p.start_sigma**2 * R for name, _, R in _measurements(u, p)} | {"x2": p.start_x2**2}
    for (chain, order), sd in zip(_orders(p).items(), (p.start_D, p.start_u, p.start_u), strict=True):
        for i, name in enumerate(CHAINS[chain]):
            variance[name] = (sd * p.start_rate**i) ** 2 * (order > i)
    return ca.vertcat(*(variance[name] for name in QUANTITIES))


def gains(s: Sizes, T: float) -> Mapping[str, float]:
    """Noise and densities for a recording: docs/gains.md."""
    order_D, order_u = (int(PARAMETERS[name].default) for name in ("order_D", "order_u"))
    sigma_L = math.sqrt(s.sigma_L1 * s.sigma_L2)
    # a chain of n integrators is as fast as w = (s/(σ√T))^(1/n)
    s_u = sigma_L * math.sqrt(T) / s.eps_L3 ** (order_u + 1)
    return {
        "sigma_1": s.sigma_1,
        "sigma_F1": s.sigma_F1,
        "sigma_F2": s.sigma_F2,
        "s_D": s.sigma_1 * math.sqrt(T) / s.eps_1 ** (order_D + 2),
        "s_u1": s_u,
        "s_u2": s_u,
    }


KALMAN = Observer("KF", kalman, gains=gains)
