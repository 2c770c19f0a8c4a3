"""Where the estimates of a recording start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import casadi as ca

from ...model.block import Block, Symbols
from ...model.symbols import hat
from ...model.system import System


def at_rest(system: System, first: Sequence[float]) -> dict[str, float]:
    """x̂(0) of positions and tendon lengths (joints + muscles, dimensionless), by the observers' names for it."""
    known = dict(zip((*system.joint("y"), *system.muscle("z")), map(float, first), strict=True))
    return {path: known[source] if source else 0.0 for path, source in first_inputs(system).items()}


def first_inputs(system: System) -> Mapping[str, str]:
    """The input that each number of x̂(0) is at the first sample; none of a velocity, which is 0."""
    sources = dict(zip(system.joint("q"), system.joint("y"), strict=True))
    sources |= dict(zip(system.muscle("L_S"), system.muscle("z"), strict=True))
    sources |= dict.fromkeys(system.joint("dq"), "")
    return {f"initial.{hat(name)}": source for name, source in sources.items()}


def begun(block: Block, system: System) -> Block:
    """The observer with x̂(0) from its first sample in the place of numbers for it."""
    sources = {path: source for path, source in first_inputs(system).items() if path in block.p}
    u = Symbols({**{name: ca.SX.sym(name) for name in sources.values() if name}, **block.u})
    old = ca.vertcat(*(block.p[path] for path in sources))
    new = ca.vertcat(*(u[source] if source else ca.SX(0) for source in sources.values()))
    x0 = Symbols({name: ca.substitute(start, old, new) for name, start in block.x0.items()}) if sources else block.x0
    kept = [name for name in block.p if name not in sources]
    parameters = {name: block.parameters[name] for name in kept}
    return replace(block, u=u, x0=x0, p=block.p.only(kept), parameters=parameters)
