"""How an observer starts on a recording: its gains, where its estimates begin, and its steps from sample to sample."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...model.block import Block
from ...model.symbols import hat
from ...model.system import System
from ...observers import Observer
from ...observers.observer import SystemSizes
from ..laboratory.subject import Subject
from ..scenarios.paths import Paths, block_paths
from .substeps import substeps


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
    known = dict(zip((*system.joint("q"), *system.muscle("L_S")), first, strict=True))
    known |= dict.fromkeys(system.joint("dq"), 0.0)
    return {f"initial.{hat(name)}": float(value) for name, value in known.items()}
