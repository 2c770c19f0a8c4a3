"""Observers of recordings as one compiled bank, for the curves of a pair of muscles."""

from __future__ import annotations

import functools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ...codegen.bank import Bank
from ...codegen.recordings.filters import CompiledBank, Filter
from ...codegen.stepper import STAGES
from ...model.arrays import Array
from ...model.block import Block, Symbols, symbols
from ...model.system import System
from ...observers import Observer, estimator_of
from ...observers.slopes import tendon_slopes
from ...observers.tendons import tendons, tendons_of_a_step

# samples between two words of progress
_CHUNK = 65_536
# periods that a step may be longer than usual; RK4 has 10 % before it is unstable
_JITTER = 0.05
_LENGTHS = "lengths"


@functools.lru_cache(maxsize=8)
def follower_bank(system: System, corrected: bool, observers: tuple[Observer, ...]) -> Bank:
    """All of these observers that follow samples one by one, and first one that only tells the tendons' state."""
    blocks = [estimator_of(observer, corrected, system) for observer in observers if not observer.fitted]
    return Bank(system.measured, tendons(system), tendons_of_a_step(STAGES, system), (_lengths(system), *blocks))


@functools.lru_cache(maxsize=8)
def fitted_blocks(system: System, corrected: bool, observers: tuple[Observer, ...]) -> tuple[Block, ...]:
    """The others, to which a recording is given as a whole."""
    several = (observer for observer in observers if observer.fitted)
    return tuple(
        observer.apart(system) if observer.apart and not system.paper else estimator_of(observer, corrected, system)
        for observer in several
    )


@functools.lru_cache(maxsize=8)
def compiled_bank(bank: Bank) -> CompiledBank:
    """The bank as machine code."""
    return CompiledBank(bank)


def measured_tendons(compiled: CompiledBank, numbers: Array, y: Array) -> tuple[Array, Array]:
    """Tendon lengths (n × muscles) that measurements y tell, and the slopes of the tendons there (n × muscles)."""
    # without states time does not matter
    told = compiled.follow(_LENGTHS, numbers, 1).samples(np.arange(float(len(y))), y).y
    muscles = told.shape[1] // 2
    return told[:, :muscles], told[:, muscles:]


def lengths_block(bank: Bank) -> Block:
    """The one that tells the lengths and slopes."""
    return bank.observers[0]


def followed(filter_: Filter, period: float, t: Array, y: Array) -> Iterator[tuple[slice, Array, Array]]:
    """Samples, and outputs and guards there, piece by piece.

    period: that of the substeps of the filter; longer steps are filled with samples in straight lines.
    """
    for start in range(0, len(t), _CHUNK):
        piece, before = slice(start, start + _CHUNK), slice(max(0, start - 1), start + _CHUNK)
        times, values, places = _filled(t[before], y[before], period)
        new = min(start, 1)  # the last sample of the piece before has been seen
        passed = filter_.samples(times[new:], values[new:])
        places = places[new:] - new
        yield piece, passed.y[places], passed.guards[places]


def _filled(t: Array, y: Array, period: float) -> tuple[Array, Array, NDArray[np.int64]]:
    """Samples with further ones in straight lines wherever a step is longer than usual, and the places of the given."""
    parts = np.maximum(np.ceil(np.diff(t) / period - _JITTER), 1)
    places = np.concatenate([[0], np.cumsum(parts)]).astype(np.int64)
    if places[-1] == len(t) - 1:
        return t, y, places
    n = np.arange(places[-1] + 1)
    return np.interp(n, places, t), np.stack([np.interp(n, places, column) for column in y.T], axis=1), places


def _lengths(system: System) -> Block:
    slopes = tendon_slopes(system)
    u = Symbols({**symbols(system.measured), **slopes.u})
    y = Symbols({**slopes.u.only(system.tendons), **slopes.y})
    return Block(_LENGTHS, u=u, p=slopes.p, parameters=slopes.parameters, y=y)
