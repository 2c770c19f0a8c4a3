"""The closed loop with every registered observer, and its table of paths: the paper's, or a mechanism's."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...codegen.bank import Bank
from ...codegen.loop import Loop
from ...codegen.stepper import STAGES
from ...model.block import Block
from ...model.curves import NGUYEN2019, Curves
from ...model.loops.closed_loop import ESTIMATED, ESTIMATED_WITH_RATE, KNOWN, closed_loop
from ...model.loops.mechanism_loop import mechanism_loop
from ...model.plant import DRIVES
from ...model.sensors import NOISE_CHANNELS, mechanism_sensors, noise_channels, sensors
from ...model.signals.pulses import PULSES
from ...model.symbols import QUANTITIES, hat, kind_of
from ...model.system import System, pair_system
from ...observers import OBSERVERS, Observer, baseline_estimator, estimator_of
from ...observers.feedback import eyes, saturation
from ...observers.score import MEASURES, score
from ...observers.tendons import tendons, tendons_of_a_step
from ..laboratory.subject import Subject
from .paths import TIMES, Paths, paths_of

# what a controller may know of Δ
DELTAS = {"known": KNOWN, "estimated": ESTIMATED, "estimated with rate": ESTIMATED_WITH_RATE}


@functools.lru_cache(maxsize=16)
def paper_loop(
    drive: str,
    curves: Curves,
    observers: tuple[Observer, ...] | None = None,
    corrected: bool = False,
    controller: Block | None = None,
    quantities: tuple[str, ...] = QUANTITIES,
    measures: tuple[str, ...] = MEASURES,
) -> Loop:
    """The closed loop with the baseline and some observers, layers `corrected` or not; only what is named is scored.

    observers: all that are registered by default, so that one library serves whatever is asked for.
    """
    banked = tuple(OBSERVERS.values()) if observers is None else observers
    activations = _scored_activations(quantities)
    return Loop(
        truth=_seen(closed_loop(drive, curves, controller), activations),
        sensors=sensors(),
        bank=_bank(pair_system(curves), banked, corrected, activations),
        score=score(quantities, measures),
        noise=NOISE_CHANNELS,
        pulses=PULSES,
    )


@functools.lru_cache(maxsize=16)
def closed_by(loop: Loop, drive: str, curves: Curves, observer: Observer, corrected: bool, Delta: str) -> Loop:
    """The same loop, whose controller knows the estimates of `observer`, and of Δ what DELTAS has under that name."""
    system = pair_system(curves)
    sees = eyes(estimator_of(observer, corrected, system, activations=False), tendons(system))
    activations = any(kind_of(name) == "a" for name in loop.truth.y)
    return replace(loop, truth=_seen(closed_loop(drive, curves, None, sees, DELTAS[Delta]), activations))


@functools.lru_cache(maxsize=16)
def loop_of_mechanism(
    subject: Subject,
    drive: str,
    tracked: tuple[str, ...],
    observers: tuple[Observer, ...],
    corrected: bool,
    quantities: tuple[str, ...],
    measures: tuple[str, ...],
) -> Loop:
    """The same of a mechanism; tracked: what its controller leads along the reference."""
    system, activations = subject.system, _scored_activations(quantities)
    return Loop(
        truth=_seen(mechanism_loop(system, drive, tracked, subject.scales.rate), activations),
        sensors=mechanism_sensors(system),
        bank=_bank(system, observers, corrected, activations),
        score=score(quantities, measures),
        noise=noise_channels(system),
        pulses=(),
    )


def _scored_activations(quantities: Sequence[str]) -> bool:
    return any(kind_of(name) == "a" for name in quantities)


def _seen(truth: Block, activations: bool) -> Block:
    """The truth without what no one looks at while activations are not scored."""
    if activations:
        return truth
    unseen = [name for name in truth.y if kind_of(name) == "a" or name.partition(".")[0] == "r"]
    return replace(truth, y=truth.y.only(name for name in truth.y if name not in unseen))


# the same for each drive
@functools.lru_cache(maxsize=16)
def _bank(system: System, observers: tuple[Observer, ...], corrected: bool, activations: bool) -> Bank:
    """The baseline and the observers, as estimators."""
    estimators = [estimator_of(observer, corrected, system, activations) for observer in observers]
    front, near = tendons(system), tendons_of_a_step(STAGES, system)
    return Bank(system.measured, front, near, (baseline_estimator(system, activations), *estimators))


@functools.lru_cache(maxsize=16)
def all_paths(own: tuple[Observer, ...] = (), curves: Curves = NGUYEN2019, corrected: bool = False) -> Paths:
    """The table of all paths of the pair, whatever drives the plant; `own` are a user's observers."""
    # spelled as a run spells it, which finds the loop in memory
    rest = (None, QUANTITIES, MEASURES)
    loops = [paper_loop(drive, curves, (*OBSERVERS.values(), *own), corrected, *rest) for drive in DRIVES]
    first = loops[0]
    return paths_of([*(loop.truth for loop in loops), saturation(), first.sensors, *first.observers, first.score])


@functools.lru_cache(maxsize=16)
def paths_of_mechanism(
    subject: Subject, drives: tuple[str, ...], tracked: tuple[str, ...], own: tuple[Observer, ...], corrected: bool
) -> Paths:
    """The same of a mechanism with any of the drives: its numbers are what they are usually."""
    system = subject.system
    chained = tuple(observer for observer in OBSERVERS.values() if observer.chains)
    scored = (system.quantities, MEASURES)
    loops = [loop_of_mechanism(subject, drive, tracked, (*chained, *own), corrected, *scored) for drive in drives]
    return paths_of(
        [*(loop.truth for loop in loops), loops[0].sensors, *loops[0].observers, loops[0].score],
        TIMES,
        {"joint": system.joints, "muscle": system.muscles},
        _usual(subject, tracked),
    )


def _usual(subject: Subject, tracked: Sequence[str]) -> dict[str, float]:
    """The muscles' numbers, a start in the middle of all ranges, and a reference that stays there."""
    system, laws = subject.system, subject.laws
    ranges = [bound.range for bound in subject.positions.values()]
    middle = np.array([sum(limits) / 2 if limits else 0.0 for limits in ranges]) / subject.scales.coordinates
    start = dict(zip(system.joint("q"), middle.tolist(), strict=True))
    slack = {
        name: subject.scales.numbers[f"{of}.L_slack"]
        for of, name in zip(system.muscles, system.muscle("L_S"), strict=True)
    }
    return {
        **subject.scales.numbers,
        **{f"initial.{name}": value for name, value in start.items()},
        **{f"initial.{hat(name)}": value for name, value in {**start, **slack}.items()},
        **{f"reference.{name}.offset": float(value) for name, value in laws.places(middle).items() if name in tracked},
    }
