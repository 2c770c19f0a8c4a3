"""The paper's closed loop with every registered observer, its table of paths, and its library."""

from __future__ import annotations

import functools
from dataclasses import replace

from ...codegen.bank import Bank
from ...codegen.loop import Loop
from ...codegen.stepper import STAGES
from ...model.block import Block
from ...model.loops.closed_loop import closed_loop
from ...model.curves import NGUYEN2019, Curves
from ...model.plant import DRIVES
from ...model.sensors import NOISE_CHANNELS, sensors
from ...model.signals.pulses import PULSES
from ...model.symbols import ACTIVATIONS, QUANTITIES
from ...model.system import pair_system
from ...observers import OBSERVERS, Observer, baseline_estimator, estimator_of
from ...observers.score import MEASURES, score
from ...observers.tendons import tendons, tendons_of_a_step
from .paths import Paths, paths_of

# outputs of the truth that no one looks at while activations are not scored
_UNSEEN = {*ACTIVATIONS, "r"}


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
    activations = not ACTIVATIONS.isdisjoint(quantities)
    truth = closed_loop(drive, curves, controller)
    banked = tuple(OBSERVERS.values()) if observers is None else observers
    return Loop(
        truth=truth if activations else replace(truth, y=truth.y.only(name for name in truth.y if name not in _UNSEEN)),
        sensors=sensors(),
        bank=_bank(curves, banked, corrected, activations),
        score=score(quantities, measures),
        noise=NOISE_CHANNELS,
        pulses=PULSES,
    )


# the same for each drive
@functools.lru_cache(maxsize=16)
def _bank(curves: Curves, observers: tuple[Observer, ...], corrected: bool, activations: bool) -> Bank:
    """The baseline and the observers, as estimators."""
    system = pair_system(curves)
    estimators = [estimator_of(observer, corrected, system, activations) for observer in observers]
    front, near = tendons(system), tendons_of_a_step(STAGES, system)
    return Bank(system.measured, front, near, (baseline_estimator(system, activations), *estimators))


@functools.lru_cache(maxsize=16)
def all_paths(own: tuple[Observer, ...] = (), curves: Curves = NGUYEN2019, corrected: bool = False) -> Paths:
    """The table of all paths, whatever drives the plant; `own` are a user's observers."""
    # spelled as a run spells it, which finds the loop in memory
    rest = (None, QUANTITIES, MEASURES)
    loops = [paper_loop(drive, curves, (*OBSERVERS.values(), *own), corrected, *rest) for drive in DRIVES]
    return paths_of([*(loop.truth for loop in loops), loops[0].sensors, *loops[0].observers, loops[0].score])
