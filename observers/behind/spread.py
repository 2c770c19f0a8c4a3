"""How sure an observer is: standard deviations of all that it estimates, from the covariance of its states."""

from __future__ import annotations

import itertools

import casadi as ca

from ...model.block import Block, Symbols, symbols
from ...model.dialect import clamp
from ...model.symbols import QUANTITIES
from ...model.system import PAIR, System
from ..ports import ESTIMATES
from .activation import activation_parameters, formulas

# what the activation and the fibre length of each muscle follow from
_OF_MUSCLE = {1: ("x1", "x3", "u1"), 2: ("x1", "x4", "u2")}
_ALONE = tuple(name.removesuffix("_hat") for name in ESTIMATES)


def entry(a: str, b: str) -> str:
    """The name of the covariance of two quantities; `a` comes first in the table of signals."""
    return f"P.{a}.{b}"


# outputs of an observer that knows how sure it is, beside its estimates
COVARIANCES = (
    *(entry(name, name) for name in _ALONE),
    *(entry(a, b) for of in _OF_MUSCLE.values() for a, b in itertools.combinations(of, 2)),
)


def sd(name: str) -> str:
    """The name of the standard deviation of the estimate of `name`."""
    return f"{name}_sd"


FIBRES = ("L_C1", "L_C2")
SPREADS = tuple(sd(name) for name in (*QUANTITIES, *FIBRES))


def spread(system: System = PAIR) -> Block:
    """Inputs: the estimates and the COVARIANCES of a pair; outputs: the SPREADS."""
    u, parameters = symbols([*ESTIMATES, *COVARIANCES]), activation_parameters(system)
    p = symbols(parameters)
    variance = {name: u[entry(name, name)] for name in _ALONE}
    for (j, of), f in zip(_OF_MUSCLE.items(), formulas(system, u, p), strict=True):
        P = ca.vertcat(*(ca.horzcat(*(u[entry(*sorted((a, b), key=of.index))] for b in of)) for a in of))
        # L_Cj = ±x₁ − x_{j+2} + …
        J_L = ca.SX([[1 if j == 1 else -1, -1, 0]])
        # σ² = J P Jᵀ,  J = ∂â/∂(x̂₁, x̂_{j+2}, û_j)
        J = ca.jacobian(f.a, ca.vertcat(u.x1_hat, u[f"x{j + 2}_hat"], f.drive))
        J = ca.substitute(J, f.drive, clamp(u[f"u{j}_hat"], f.low, f.high))
        variance |= {f"a{j}": J @ P @ J.T, f"L_C{j}": J_L @ P @ J_L.T}
    # rounding can leave a variance that is 0 a little below it
    y = Symbols({sd(name): ca.sqrt(ca.fmax(variance[name], 0)) for name in (*QUANTITIES, *FIBRES)})
    return Block("spread", u=u, p=p, parameters=parameters, y=y)
