"""How an observer starts on a recording: its gains, where its estimates begin, and its steps from sample to sample."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import casadi as ca

from ...model.block import Block, Symbols
from ...model.symbols import hat
from ...model.system import System
from ...observers import Observer
from ...observers.observer import SystemSizes
from ..files.errors import ScenarioError
from ..files.quote import shown
from ..laboratory.scales import Scales
from ..laboratory.subject import Subject
from ..scenarios.layers import Value
from ..scenarios.paths import Paths, block_paths
from ..scenarios.scenario import checked_number
from .substeps import LONGEST_PERIOD, substeps


def longest_period(scales: Scales) -> float:
    """How far samples may usually be apart, in s."""
    return LONGEST_PERIOD / scales.rate


def too_rare(period: float, scales: Scales) -> str:
    """Why samples that are a period apart, in s, cannot be followed; empty if they can."""
    if period <= longest_period(scales):
        return ""
    return (
        f"a sample every {period:.3g} s is too few for muscles of v_max = {scales.rate:g}/s; "
        f"at most {longest_period(scales):.3g} s"
    )


def gains_by_hand(changes: Mapping[str, Value], chosen: Collection[str], paths: Paths) -> dict[str, float]:
    """Path → value of gains that are given. ScenarioError for what is no gain of an observer that was chosen."""
    refuse_foreign(changes, chosen)
    return paths.spread({path: checked_number(path, value, paths) for path, value in changes.items()})


def refuse_foreign(changes: Iterable[str], chosen: Collection[str]) -> None:
    """ScenarioError for a path of what is no observer that was chosen."""
    for path in changes:
        if path.partition(".")[0] not in chosen:
            raise ScenarioError(
                f"{shown(path)} is no gain of {', '.join(chosen)}; the muscle file has all other numbers"
            )


def gains_of_rule(observer: Observer, system: System, block: Block, sizes: SystemSizes, T: float) -> dict[str, float]:
    """Path → value of the gains of `block`, which `observer` has built, for a recording of a sampling period T."""
    gains = observer.gains_of(system, sizes, T)
    return gains_of_block(block, {f"{block.name}.{gain}": value for gain, value in gains.items()})


def gains_of_block(block: Block, gains: Mapping[str, float]) -> dict[str, float]:
    """Its own among the gains, path → value: an observer that is not corrected has no use for some."""
    own = block_paths(block)
    return {path: value for path, value in gains.items() if path in own}


def begun(
    observer: Observer,
    subject: Subject,
    paths: Paths,
    block: Block,
    gains: Mapping[str, float],
    first: Sequence[float],
    T: float,
) -> tuple[dict[str, float], int]:
    """The numbers of `block` by name, x̂(0) among them, and its RK4 steps in a sampling period T.

    first: what is measured at the first sample, then the tendon lengths that this tells, dimensionless.
    """
    system = subject.system
    joints, measured = len(system.joints), len(system.measured)
    rest = at_rest(system, [*first[:joints], *first[measured:]])
    values = paths.values(block, {**subject.scales.numbers, **gains, **rest})
    numbers = dict(zip(block.p, values, strict=True))
    inputs = {"t": 0.0, **dict(zip((*system.measured, *system.tendons), first, strict=True))}
    return numbers, substeps(observer, system, block, numbers, inputs, T)


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


def from_first_sample(block: Block, system: System) -> Block:
    """The observer with x̂(0) from its first sample in the place of numbers for it."""
    sources = {path: source for path, source in first_inputs(system).items() if path in block.p}
    u = Symbols({**{name: ca.SX.sym(name) for name in sources.values() if name}, **block.u})
    old = ca.vertcat(*(block.p[path] for path in sources))
    new = ca.vertcat(*(u[source] if source else ca.SX(0) for source in sources.values()))
    x0 = Symbols({name: ca.substitute(start, old, new) for name, start in block.x0.items()}) if sources else block.x0
    kept = [name for name in block.p if name not in sources]
    parameters = {name: block.parameters[name] for name in kept}
    return replace(block, u=u, x0=x0, p=block.p.only(kept), parameters=parameters)
