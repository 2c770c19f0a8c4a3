"""How sure an observer is: standard deviations of all that it estimates, from the covariance of its states."""

from __future__ import annotations

import itertools

import casadi as ca

from ...model.block import Block, Symbols, symbols
from ...model.dialect import clamp
from ...model.symbols import hat
from ...model.system import PAIR, System
from .activation import activation_parameters, formulas


def entry(a: str, b: str) -> str:
    """The name of the covariance of two quantities; `a` comes first in the table of signals."""
    return f"P.{a}.{b}"


def sd(name: str) -> str:
    """The name of the standard deviation of the estimate of `name`."""
    return f"{name}_sd"


def _estimated(system: System) -> list[str]:
    return [name.removesuffix("_hat") for name in system.estimates]


def of_muscle(system: System, muscle: str) -> tuple[str, ...]:
    """What the activation and the fibre length of a muscle follow from."""
    return (*system.joint("q"), system.name("L_S", muscle), system.name("u", muscle))


def covariances(system: System) -> tuple[str, ...]:
    """Outputs of an observer that knows how sure it is, beside its estimates."""
    alone = (entry(name, name) for name in _estimated(system))
    together = (
        entry(a, b) for muscle in system.muscles for a, b in itertools.combinations(of_muscle(system, muscle), 2)
    )
    return tuple(dict.fromkeys((*alone, *together)))


def spreads(system: System) -> tuple[str, ...]:
    """The standard deviations of all that is estimated, and of the fibre lengths."""
    return tuple(sd(name) for name in (*system.quantities, *system.muscle("L_C")))


# of the pair
COVARIANCES, SPREADS = covariances(PAIR), spreads(PAIR)


def spread(system: System = PAIR) -> Block:
    """Inputs: the estimates and their `covariances`; outputs: the `spreads`."""
    u, parameters = symbols([*system.estimates, *covariances(system)]), activation_parameters(system)
    p = symbols(parameters)
    variance = {name: u[entry(name, name)] for name in _estimated(system)}
    for f in formulas(system, u, p):
        a, L_C, u_hat = (system.name(signal, f.muscle) for signal in ("a", "L_C", "u"))
        of = of_muscle(system, f.muscle)
        P = ca.vertcat(*(ca.horzcat(*(u[entry(*sorted((a, b), key=of.index))] for b in of)) for a in of))
        # σ² = J P Jᵀ,  J = ∂(â, L̂_C)/∂(q̂, L̂_S, û)
        about = ca.vertcat(*(u[hat(name)] for name in of[:-1]), f.drive)
        for name, value in ((a, f.a), (L_C, f.L_C)):
            J = ca.substitute(ca.jacobian(value, about), f.drive, clamp(u[hat(u_hat)], f.low, f.high))
            variance[name] = J @ P @ J.T
    # rounding can leave a variance that is 0 a little below it
    y = Symbols({name: ca.sqrt(ca.fmax(variance[name.removesuffix("_sd")], 0)) for name in spreads(system)})
    return Block("spread", u=u, p=p, parameters=parameters, y=y)
