"""What the filters of joints and muscles tell together: all estimates of a system, and how sure they are.

A muscle's chain knows L̇_m as the joints tell it. What that is off by, û is off by as well, since L_S is measured.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import casadi as ca

from ....model.block import Block, Parameters, Symbols, symbols
from ....model.limits import limits
from ....model.symbols import hat
from ....model.system import System
from ....model.wiring import rename, wire
from ...behind.activation import activation_estimate
from ...behind.spread import covariances, entry, spread, spreads
from ...slopes import tendon_slopes
from ..model import Model
from .activations import LAW
from .integrators import JOINT, JOINT_MODEL, MUSCLE, MUSCLE_MODEL

# the variance of L̇_m as the joints tell it
MOVED = "moved"
# how the names of that begin
_START = "start_"


def told(model: Model) -> tuple[str, ...]:
    """The names of what a chain tells."""
    n = len(model.quantities)
    return tuple(model.told(ca.SX(n, 1), ca.SX(n, n), symbols(model.inputs)))


def estimates_apart(system: System) -> Block:
    """Inputs: what each chain tells, as `elbow.x1`, `BRA.u1` and so on; outputs: all estimates and their deviations.

    Its numbers are those of the chains too, `elbow.s_D`, `BRA.s_u1`, and with what all of them begin.
    """
    parts = [_together(system), activation_estimate(system), spread(system)]
    first, *behind = parts
    connections = {f"{first.name}.{port}": port for port in first.u}
    connections |= {f"{part.name}.{port}": f"{first.name}.{port}" for part in behind for port in part.u}
    wired = wire("kalman", parts, connections, dict.fromkeys(first.u, "staged"))
    names = {key: key.partition(".")[2] for key in (*wired.y, *wired.p, *wired.guards)}
    outputs = [*system.estimates, *map(hat, system.muscle("a")), *spreads(system)]
    whole = rename(wired, "kalman", names, outputs)
    parameters = {**numbers(system), **tendon_slopes(system).parameters, **whole.parameters}
    p = Symbols({name: whole.p.get(name, ca.SX.sym(name)) for name in parameters})
    return replace(whole, parameters=parameters, p=p, limits=limits(system, whole.y, p))


def numbers(system: System) -> Parameters:
    """Those of each chain, and with what all begin."""
    muscle = {**MUSCLE, **LAW}
    chains = {**dict.fromkeys(system.joints, JOINT), **dict.fromkeys(system.muscles, muscle)}
    own = {
        f"{of}.{name}": parameter
        for of, chain in chains.items()
        for name, parameter in chain.items()
        if not name.startswith(_START)
    }
    shared = {name: parameter for name, parameter in {**JOINT, **MUSCLE, **LAW}.items() if name.startswith(_START)}
    return {**own, **shared}


def _together(system: System) -> Block:
    """Outputs: the system's estimates and their `covariances`."""
    of_joints = (f"{of}.{name}" for of in system.joints for name in told(JOINT_MODEL))
    of_muscles = (f"{of}.{name}" for of in system.muscles for name in (*told(MUSCLE_MODEL), MOVED))
    u, y, sure = symbols([*of_joints, *of_muscles]), Symbols(), Symbols()
    for of in system.joints:
        for signal, name in (("q", "x1"), ("dq", "x2"), ("Delta", "Delta")):
            quantity = system.name(signal, of)
            y[hat(quantity)], sure[entry(quantity, quantity)] = u[f"{of}.{name}"], u[f"{of}.{entry(name, name)}"]
    for of in system.muscles:
        L_S, u_m = (system.name(signal, of) for signal in ("L_S", "u"))
        y[hat(L_S)], y[hat(u_m)] = u[f"{of}.x3"], u[f"{of}.u1"]
        for (a, one), (b, other) in itertools.combinations_with_replacement(((L_S, "x3"), (u_m, "u1")), 2):
            sure[entry(a, b)] = u[f"{of}.{entry(one, other)}"]
        sure[entry(u_m, u_m)] += u[f"{of}.{MOVED}"]
    # all others have nothing in common
    known = {name: sure.get(name, ca.SX(0)) for name in covariances(system)}
    return Block("together", u=u, y=Symbols({**y.only(system.estimates), **known}))
