"""The Kalman filter: position and forces with known noise, inputs that white noise drives; tells how sure it is."""

from __future__ import annotations

import casadi as ca

from ...model.block import Block, Symbols, symbols
from ...model.skeleton.load import pull
from ..observer import Observer, no_rates
from ..ports import SENSED
from ..slopes import SLOPES
from .apart.estimates import estimates_apart
from .inputs import INPUTS_MODEL as MODEL
from .parameters import TUNED, gains
from .states import ENTRIES, MEAN, covariance, scalars
from .update import measured, predicted

# what the last sample leaves for the straight lines to the next
_LAST = tuple(name for name in MODEL.inputs if name != "y1")


def kalman() -> Block:
    """The filter of a pair. Inputs t, y1, y2, y3, L_S1, L_S2 and the tendons' slopes; moves at samples only.

    States: 13 means, the 91 entries of their covariance, what was measured last.
    """
    mean, entries, last = symbols(MEAN), symbols(ENTRIES), symbols(f"last.{name}" for name in _LAST)
    u, p = symbols(["t", *SENSED, *SLOPES]), symbols(MODEL.parameters)
    # acc = R y/m
    now = Symbols({**u, "acc": pull((u.y2, u.y3)) / p.m})
    move = MODEL.move(last.part("last"), now, p)
    x, P = move.mean(mean.vector()), predicted(covariance(entries), move.F, move.noise(MODEL.densities(p)))
    for measurement in MODEL.measurements(now, p):
        update = measured(x, P, measurement)
        x, P = update.x, update.P
    kept = Symbols({f"last.{name}": now[name] for name in _LAST})
    x0, variances = MODEL.start(now, p)
    return Block(
        "kalman",
        x=Symbols({**mean, **entries, **last}),
        u=u,
        p=p,
        parameters=MODEL.parameters,
        next=Symbols({**_named(x), **scalars(P), **kept}),
        x0=Symbols({**_named(x0), **scalars(ca.diag(variances)), **kept}),
        y=MODEL.told(mean.vector(), covariance(entries), now),
    )


def _named(mean: ca.SX) -> dict[str, ca.SX]:
    return dict(zip(MEAN, ca.vertsplit(mean), strict=True))


KALMAN = Observer("KF", whole=kalman, apart=estimates_apart, gains=gains, rates=no_rates, fitted=True, tuned=TUNED)
