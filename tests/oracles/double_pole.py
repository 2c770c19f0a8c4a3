"""The high-gain observer written once more, its poles by their rate: what a new observer's file looks like."""

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from hillobs.model.block import Block, Parameter, Symbols, symbols
from hillobs.model.skeleton.load import MASS
from hillobs.observers.chained import (
    OF_JOINT,
    OF_MUSCLE,
    START,
    START_OF_JOINT,
    START_OF_MUSCLE,
    Chains,
    chain,
    chained,
)
from hillobs.observers.conditions import Condition, below
from hillobs.observers.observer import Observer, Sizes

PARAMETERS = {
    "rate": Parameter(10.0, "of all poles", "a test", above=0),
    "m": MASS,
    **START,
}


def chains(corrected: bool = False) -> Chains:
    return Chains("double_pole", joint(), muscle(), PARAMETERS)


def double_pole(name: str = "double_pole") -> Block:
    return replace(chained(chains()), name=name)


def joint() -> Block:
    x, u, p = symbols("x1_hat x2_hat Delta_hat"), symbols(OF_JOINT), symbols(["rate", *START_OF_JOINT])
    e1, r = u.y1 - x.x1_hat, p.rate
    dx = Symbols(x1_hat=x.x2_hat + 3 * r * e1, x2_hat=u.acc + x.Delta_hat + 3 * r**2 * e1, Delta_hat=r**3 * e1)
    return chain("joint", x, u, p, PARAMETERS, dx)


def muscle() -> Block:
    x, u, p = symbols("x3_hat u1_hat"), symbols(OF_MUSCLE), symbols(["rate", *START_OF_MUSCLE])
    e3, r = u.L_S1 - x.x3_hat, p.rate
    dx = Symbols(x3_hat=u.rate + x.u1_hat + 2 * r * e3, u1_hat=r**2 * e3)
    return chain("muscle", x, u, p, PARAMETERS, dx)


def theorem(p: Symbols, facts: Symbols) -> list[Condition]:
    return [below("r < 200", p.rate, 200)]


def rates(p: Symbols) -> Mapping[str, ca.SX]:
    return {"r": p.rate}


def gains(s: Sizes, T: float) -> dict[str, float]:
    return {"rate": 1 / s.eps_1}


DOUBLE_POLE = Observer("2P", chains, None, theorem, gains, rates, 0.75)
