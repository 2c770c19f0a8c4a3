"""An observer out of chains: one for each joint, one for each muscle, and what the measured forces tell of both.

With the forces measured a joint is q̈ = α + Δ, α known, and a tendon L̇_S = −Rᵀq̇ + u, R known. Nothing else couples them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import casadi as ca

from ..model.block import Block, Parameter, Parameters, Symbols, symbols
from ..model.symbols import MUSCLES, hat
from ..model.system import PAIR, System
from ..model.wiring import many, rename, wire

# what a chain has in front of it, and what it tells: by the names that these have for the mass and for muscle 1
OF_JOINT, OF_MUSCLE = ("y1", "acc"), ("L_S1", "rate")
_JOINT = {"x1_hat": "q", "x2_hat": "dq", "Delta_hat": "Delta"}
_MUSCLE = {"x3_hat": "L_S", "u1_hat": "u"}
# a joint's chain tells the velocity that its tendons move with, and maybe what that lacks; a muscle's may ask for it
VELOCITY, LACK = "velocity", "lack"

_INITIAL = "initial."


def _start(x: str, value: float) -> Parameter:
    sentence = f"estimate of {x} at the start"
    return Parameter(value, sentence, "chosen, docs/observers.md#start", shared=f"{_INITIAL}{hat(x)}")


START: Parameters = {
    f"{_INITIAL}{hat(x)}": _start(x, value) for x, value in {"x1": 2.62, "x2": 0.0, "x3": 2.01, "x4": 2.01}.items()
}
START_OF_JOINT, START_OF_MUSCLE = ("initial.x1_hat", "initial.x2_hat"), ("initial.x3_hat",)


@dataclass(frozen=True)
class Chains:
    """An observer by its name: the chain of the mass and that of muscle 1, by the names that it has for the pair.

    parameters: all numbers of the pair's observer. second: names of muscle 1 → those of muscle 2, where they differ.
    """

    name: str
    joint: Block
    muscle: Block
    parameters: Parameters
    second: Mapping[str, str] = field(default_factory=dict)


def chained(chains: Chains, system: System = PAIR) -> Block:
    """The observer of a system. Its inputs are the measurements, and the tendon lengths that these tell."""
    return _observer(chains, system, _forces(system, LACK in chains.joint.y))


def told(chains: Chains, system: System) -> Block:
    """The same, told accelerations instead of forces, as `acc.elbow` and so on."""
    return _observer(chains, system, _accelerations(system))


def _observer(chains: Chains, system: System, forces: Block) -> Block:
    joints = dict(zip(system.joints, many(chains.joint, _parts("joint", system.joints)), strict=True))
    muscles = dict(zip(system.muscles, many(chains.muscle, _parts("muscle", system.muscles)), strict=True))
    outside = [port for port in forces.u if port.partition(".")[0] not in (VELOCITY, LACK)]
    connections: dict[str, str | float] = {f"forces.{port}": port for port in outside}
    names: dict[str, str] = {f"forces.{key}": key for key in forces.p}
    for of, part in joints.items():
        told = {"y1": system.name("y", of), "acc": f"forces.acc.{of}"}
        connections |= {f"{part.name}.{port}": told[port] for port in part.u}
        connections |= {f"forces.{port}.{of}": f"{part.name}.{port}" for port in (VELOCITY, LACK) if port in part.y}
        names |= _renamed(part, _JOINT, system, of, {})
    for of, part in muscles.items():
        told = {"L_S1": system.name("z", of), **{port: f"forces.{port}.{of}" for port in ("rate", LACK)}}
        connections |= {f"{part.name}.{port}": told[port] for port in part.u}
        names |= _renamed(part, _MUSCLE, system, of, chains.second if of == MUSCLES[1] else {})
    external = dict.fromkeys((*outside, *system.tendons), "staged")
    wired = wire(chains.name, [forces, *joints.values(), *muscles.values()], connections, external)
    block = rename(wired, chains.name, names, system.estimates)
    return _with_numbers(block, chains.parameters, system)


def chain(
    kind: str, x: Symbols, u: Symbols, p: Symbols, parameters: Parameters, dx: Symbols, guards: Symbols | None = None
) -> Block:
    """The chain of the mass or of muscle 1: starts at its numbers, and tells what it estimates."""
    # x̂(0) from the parameters; Δ̂(0) = û(0) = 0
    x0 = Symbols({name: p[_INITIAL + name] for name in x if _INITIAL + name in p})
    y = x.only(name for name in (*_JOINT, *_MUSCLE) if name in x)
    if "x2_hat" in x:
        y[VELOCITY] = x.x2_hat
    numbers = {name: parameters[name] for name in p}
    return Block(kind, x=x, u=u, p=p, parameters=numbers, dx=dx, x0=x0, y=y, guards=guards or Symbols())


def views(chains: Chains, system: System) -> dict[str, dict[str, str]]:
    """Joint or muscle → the numbers of the pair's observer, by the names of those that it and a neighbour have.

    What a theorem or a rate of the pair says of its numbers is so said of each chain.
    """

    def view(joint: str, muscle: str) -> dict[str, str]:
        names = {name: f"{muscle}.{name}" for name in chains.muscle.p}
        names |= {chains.second.get(name, name): number for name, number in names.items()}
        return {**names, **{name: f"{joint}.{name}" for name in chains.joint.p}}

    joint, muscle = system.joints[0], system.muscles[0]
    return {
        **{of: view(of, muscle) for of in system.joints},
        **{of: view(joint, of) for of in system.muscles},
    }


def _parts(kind: str, names: tuple[str, ...]) -> list[str]:
    return [f"{kind}{i}" for i, _ in enumerate(names)]


def _renamed(
    part: Block, estimates: Mapping[str, str], system: System, of: str, second: Mapping[str, str]
) -> dict[str, str]:
    """What the states, outputs, numbers and guards of a chain are called in the system."""

    def name(key: str) -> str:
        state = key.removeprefix(_INITIAL)
        if state in estimates:
            estimate = hat(system.name(estimates[state], of))
            return estimate if state == key else _INITIAL + estimate
        return second.get(key, key) if system.paper else f"{of}.{key}"

    kept = [key for key in (*part.x, *part.y, *part.p, *part.guards) if key not in (VELOCITY, LACK)]
    return {f"{part.name}.{key}": name(key) for key in kept}


def _forces(system: System, lacking: bool) -> Block:
    """What is known of joints and muscles once forces and positions are: acc of each joint, rate of each muscle.

    acc takes the velocities that the chains tell, as does rate; lack is the rate that goes with what velocities lack.
    """
    q, F = symbols(system.joint("y")), symbols(system.muscle("y"))
    dq = symbols(f"{VELOCITY}.{of}" for of in system.joints)
    lack = symbols(f"{LACK}.{of}" for of in system.joints if lacking)
    p = symbols(system.parameters)
    acc = system.accelerations(list(q.values()), list(dq.values()), list(F.values()), p)
    y = {f"acc.{of}": value for of, value in zip(system.joints, acc, strict=True)}
    y |= _rates("rate", system, q, dq, p) | (_rates(LACK, system, q, lack, p) if lacking else {})
    used = {symbol.name() for symbol in ca.symvar(ca.vertcat(*y.values()))}
    numbers = {key: parameter for key, parameter in system.parameters.items() if key in used}
    return Block("forces", u=Symbols({**q, **F, **dq, **lack}), p=p.only(numbers), parameters=numbers, y=Symbols(y))


def _rates(kind: str, system: System, q: Symbols, dq: Symbols, p: Symbols) -> dict[str, ca.SX]:
    rates = system.rates(list(q.values()), list(dq.values()), p)
    return {f"{kind}.{of}": rate for of, rate in zip(system.muscles, rates, strict=True)}


def _accelerations(system: System) -> Block:
    """The accelerations as they come, and the rates."""
    q, acc = symbols(system.joint("y")), symbols(f"acc.{of}" for of in system.joints)
    dq, p = symbols(f"{VELOCITY}.{of}" for of in system.joints), symbols(system.parameters)
    y = Symbols({**acc, **_rates("rate", system, q, dq, p)})
    return Block("forces", u=Symbols({**q, **acc, **dq}), y=y)


def _with_numbers(block: Block, parameters: Parameters, system: System) -> Block:
    """The observer with its numbers described and in order: the pair's as they are, others as those of muscle 1."""

    def described(key: str) -> Parameter:
        if key in parameters:
            return parameters[key]
        if key.startswith(_INITIAL):
            return _start(key.removeprefix(_INITIAL).removesuffix("_hat"), 0.0)
        # what muscle 1 shares is that of the pair
        return replace(parameters[key.rpartition(".")[2]], shared="")

    order = [key for key in (parameters if system.paper else block.p) if key in block.p]
    numbers = {key: described(key) for key in order}
    return replace(block, p=block.p.only(order), parameters=numbers)
