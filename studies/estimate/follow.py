"""Observers of recordings as one compiled bank, for the curves of a pair of muscles."""

from __future__ import annotations

import functools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ...codegen.bank import Bank
from ...codegen.filters import CompiledBank
from ...codegen.stepper import STAGES
from ...model.arrays import Array
from ...model.block import Block, Symbols, symbols
from ...model.curves import Curves, tendon_parameters
from ...model.symbols import MEASURED
from ...observers import FOLLOWERS, estimator
from ...observers.tendons import LENGTHS, tendons, tendons_of_a_step
from ..laboratory.muscles import MusclePair

# samples between two words of progress
_CHUNK = 65_536
# periods that a step may be longer than usual; RK4 has 10 % before it is unstable
_JITTER = 0.05
_LENGTHS = "lengths"


def curves_of(pair: MusclePair) -> Curves:
    """The curve sets of a pair."""
    first, second = pair.muscle1.curves, pair.muscle2.curves
    return first if first is second else (first, second)


@functools.lru_cache(maxsize=8)
def follower_bank(curves: Curves, corrected: bool) -> Bank:
    """All observers of recordings, and one that only tells the tendon lengths."""
    own = [estimator(build(corrected), curves) for build in FOLLOWERS.values()]
    return Bank(MEASURED, tendons(curves), tendons_of_a_step(STAGES, curves), (_lengths(curves), *own))


@functools.lru_cache(maxsize=8)
def compiled_bank(curves: Curves, corrected: bool) -> CompiledBank:
    """The same as machine code."""
    return CompiledBank(follower_bank(curves, corrected))


def tendon_lengths(compiled: CompiledBank, numbers: Array, y: Array) -> Array:
    """L_S1, L_S2 (n × 2) of measurements y (n × 3)."""
    # without states time does not matter
    return compiled.follow(_LENGTHS, numbers, 1).samples(np.arange(float(len(y))), y).y


def lengths_block(bank: Bank) -> Block:
    """The one that tells the lengths."""
    return bank.observers[0]


def followed(
    compiled: CompiledBank, observer: str, numbers: Array, substeps: int, period: float, t: Array, y: Array
) -> Iterator[tuple[slice, Array, Array]]:
    """Samples, and outputs and guards there, piece by piece; `substeps` are those of a step of one `period`."""
    filter_ = compiled.follow(observer, numbers, substeps)
    for start in range(0, len(t), _CHUNK):
        piece, before = slice(start, start + _CHUNK), slice(max(0, start - 1), start + _CHUNK)
        times, values, own = _filled(t[before], y[before], period)
        new = min(start, 1)  # the last sample of the piece before has been seen
        found = filter_.samples(times[new:], values[new:])
        own = own[new:] - new
        yield piece, found.y[own], found.guards[own]


def _filled(t: Array, y: Array, period: float) -> tuple[Array, Array, NDArray[np.int64]]:
    """Samples with further ones in straight lines wherever a step is longer than usual, and the places of their own."""
    parts = np.maximum(np.ceil(np.diff(t) / period - _JITTER), 1)
    own = np.concatenate([[0], np.cumsum(parts)]).astype(np.int64)
    if own[-1] == len(t) - 1:
        return t, y, own
    every = np.arange(own[-1] + 1)
    return np.interp(every, own, t), np.stack([np.interp(every, own, column) for column in y.T], axis=1), own


def _lengths(curves: Curves) -> Block:
    u, parameters = symbols([*MEASURED, *LENGTHS]), tendon_parameters(curves)
    p = symbols(parameters)
    return Block(_LENGTHS, u=u, p=p, parameters=parameters, y=Symbols({name: u[name] for name in LENGTHS}))
