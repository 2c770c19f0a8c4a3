"""The high-gain observer written once more, its poles by their rate: what a new observer's file looks like."""

from collections.abc import Mapping

import casadi as ca

from hillobs.model.block import Block, Parameter, Symbols, symbols
from hillobs.model.skeleton.load import MASS
from hillobs.observers.conditions import Condition, below
from hillobs.observers.observer import Observer, Sizes
from hillobs.observers.ports import SENSED, START, estimates, output_errors, start

PARAMETERS = {
    "rate": Parameter(10.0, "of all poles", "a test", above=0),
    "m": MASS,
    **START,
}


def double_pole(name: str = "double_pole") -> Block:
    x = symbols("x1_hat x2_hat Delta_hat x3_hat u1_hat x4_hat u2_hat")
    u, p = symbols(SENSED), symbols(PARAMETERS)
    e1, e3, e4 = output_errors(x, u)
    r = p.rate
    dx = Symbols(
        x1_hat=x.x2_hat + 3 * r * e1,
        x2_hat=(u.y3 - u.y2) / p.m + x.Delta_hat + 3 * r**2 * e1,
        Delta_hat=r**3 * e1,
        x3_hat=x.x2_hat + x.u1_hat + 2 * r * e3,
        u1_hat=r**2 * e3,
        x4_hat=-x.x2_hat + x.u2_hat + 2 * r * e4,
        u2_hat=r**2 * e4,
    )
    return Block(name, x=x, u=u, p=p, parameters=PARAMETERS, dx=dx, x0=start(p), y=estimates(x))


def theorem(p: Symbols, facts: Symbols) -> list[Condition]:
    return [below("r < 200", p.rate, 200)]


def rates(p: Symbols) -> Mapping[str, ca.SX]:
    return {"r": p.rate}


def gains(s: Sizes, T: float) -> dict[str, float]:
    return {"rate": 1 / s.eps_1}


DOUBLE_POLE = Observer("2P", double_pole, theorem, gains, rates, 0.75)
