"""Where the estimates of a recording start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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
