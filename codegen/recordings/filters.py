"""Run a compiled bank of observers over recorded measurements, in slices, so that a recording may be of any length."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...model.arrays import Array
from ...model.block import Block
from ..bank import Bank
from ..cache import BuildError
from ..constants import hoisted
from ..export import Source, export_blocks
from ..failure import Failure, failure
from ..memory import aligned
from ..shared_library import load
from ..stepper import functions
from ..toolchain import SINGLE

# steps in one call: well below 0.1 s
_SLICE = 100_000


class _Filter(ctypes.Structure):
    """`struct Filter`."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("p", "c", "x", "scales", "front_p", "front_c", "near_c")),
        ("h", ctypes.c_double),
        *((name, ctypes.c_int64) for name in ("substeps", "begun", "n")),
        ("t", ctypes.c_void_p),
        ("y", ctypes.c_void_p),
        ("results", ctypes.c_void_p),
        ("failed", ctypes.c_int64),
        ("cause", ctypes.c_int64),
    )


@dataclass(frozen=True)
class State:
    """Where an observer stands: its states, and the sample that it has seen last, at time t."""

    x: list[float]
    t: float
    y: list[float]


@dataclass(frozen=True)
class Followed:
    """What an observer made of some samples: outputs and guards, (samples × names); NaN from its failure on."""

    y: Array
    guards: Array


class CompiledBank:
    """A bank of observers as a loaded library; nothing that its methods take recompiles it."""

    def __init__(self, bank: Bank, target: str = SINGLE) -> None:
        self.bank = bank
        source = export_bank(bank)
        self.path, self.dll = load(source, target)
        self.dll.hillobs_follow.argtypes = (ctypes.c_int64, ctypes.POINTER(_Filter))
        self.dll.hillobs_follow.restype = None
        blocks: Any = source.description["blocks"]
        self.constants = {entry["name"]: int(entry["constants"]) for entry in blocks}
        self.lanes = self._ask()

    def follow(self, observer: str, numbers: ArrayLike, substeps: int) -> Filter:
        """An observer at the beginning of a recording.

        numbers: values in the order of its `p`. substeps: RK4 steps from sample to sample.
        """
        return Filter(self, observer, np.asarray(numbers, dtype=float), substeps)

    def _ask(self) -> int:
        expected = [ctypes.sizeof(_Filter)]
        for block in self.bank.exported:
            expected += [len(block.x), len(block.p), self.constants[block.name]]
            expected += [len(block.y), len(block.guards), len(block.domain)]
        found = (ctypes.c_int64 * (1 + len(expected)))()
        self.dll.hillobs_sizes(found)
        if list(found[1:]) != expected:
            raise BuildError(f"{self.path} has other sizes than the bank it was built for.")
        return int(found[0])


class Filter:
    """One observer under way; each call of `samples` or `sample` goes on where the last one ended."""

    def __init__(self, compiled: CompiledBank, observer: str, numbers: Array, substeps: int) -> None:
        bank = compiled.bank
        self._compiled, self._substeps = compiled, substeps
        self._which = [block.name for block in bank.observers].index(observer)
        self._block = bank.observers[self._which]
        if numbers.shape != (len(self._block.p),):
            raise ValueError(f"{observer} takes {len(self._block.p)} numbers")
        fronts = numbers[[list(self._block.p).index(name) for name in bank.front.p]]
        sizes = {
            "p": len(self._block.p),
            "c": compiled.constants[observer],
            "x": len(self._block.x),
            "scales": len(self._block.x) + len(self._block.y),
            "front_p": len(bank.front.p),
            "front_c": compiled.constants[bank.front.name],
            "near_c": compiled.constants[(bank.near or bank.front).name],
        }
        self._arrays = {key: aligned((max(1, size), compiled.lanes)) for key, size in sizes.items()}
        self._arrays["p"][: len(self._block.p)] = numbers[:, None]
        self._arrays["front_p"][: len(bank.front.p)] = fronts[:, None]
        self._filter = _Filter(substeps=substeps, failed=-1)
        for key, array in self._arrays.items():
            setattr(self._filter, key, array.ctypes.data)
        self._begun = False
        # the sample before the last, and the last
        self._t, self._y = np.zeros(2), np.zeros((2, len(bank.measured)))
        self._rows: Array = np.full((2, len(self._block.y) + len(self._block.guards)), np.nan)
        # their numbers, quicker to reach one by one
        self._views: Any = self._t.data, self._y.reshape(-1).data
        self._places = [[array[i:].ctypes.data for array in (self._t, self._y, self._rows)] for i in (0, 1)]
        self._pointer = ctypes.byref(self._filter)
        self.failure: Failure | None = None

    @property
    def block(self) -> Block:
        """The observer."""
        return self._block

    @property
    def row(self) -> Array:
        """Its outputs, then its guards, at the last sample, in memory that stays; NaN from a failure on."""
        last: Array = self._rows[1]
        return last

    @property
    def state(self) -> State:
        """Where it stands, after a sample at least."""
        x = self._arrays["x"][: len(self._block.x), 0]
        return State(x.tolist(), float(self._t[1]), self._y[1].tolist())

    def go_on_from(self, state: State) -> None:
        """Take the place of a filter with the same numbers, from where that stood."""
        self._arrays["x"][: len(self._block.x)] = np.array(state.x)[:, None]
        self._t[1], self._y[1], self._begun = state.t, state.y, True

    def samples(self, t: Array, y: Array) -> Followed:
        """What it makes of the samples at times t (n), measurements y (n × measured), of the Block's time unit."""
        results = np.full((len(t), len(self.row)), np.nan)
        step = max(1, _SLICE // self._substeps)
        for start in range(0, len(t), step):
            if self.failure:
                break
            results[start : start + step] = self._slice(t[start : start + step], y[start : start + step])
        if len(t):
            self.row[:] = results[-1]
        return Followed(results[:, : len(self._block.y)], results[:, len(self._block.y) :])

    def sample(self, t: float, y: Sequence[float]) -> None:
        """Go on to one sample, without taking memory; the result is `row`."""
        if self.failure:
            return
        times, values = self._views
        measured = len(y)
        times[0], times[1] = times[1], t
        values[:measured] = values[measured:]
        for i, value in enumerate(y, measured):
            values[i] = value
        if self._call(1 + self._begun, *self._places[not self._begun]) >= 0:
            self.row[:] = np.nan
            self._fail(t)
        self._begun = True

    def _slice(self, t: Array, y: Array) -> Array:
        # the last sample is passed again: measurements are interpolated linearly from it to the next
        begun = int(self._begun)
        times = np.ascontiguousarray(np.concatenate([self._t[2 - begun :], t]), dtype=float)
        values = np.ascontiguousarray(np.concatenate([self._y[2 - begun :], y]), dtype=float)
        results = np.full((len(times), len(self.row)), np.nan)
        if (at := self._call(len(times), times.ctypes.data, values.ctypes.data, results.ctypes.data)) >= 0:
            self._fail(float(times[at]))
        self._t[1], self._y[1], self._begun = times[-1], values[-1], True
        return results[begun:]

    def _call(self, n: int, t: int, y: int, results: int) -> int:
        """Follow n samples, the first of which was seen if any was; the sample of a failure, or −1."""
        filter_ = self._filter
        filter_.begun, filter_.n, filter_.t, filter_.y, filter_.results = self._begun, n, t, y, results
        self._compiled.dll.hillobs_follow(self._which, self._pointer)
        return int(filter_.failed)

    def _fail(self, t: float) -> None:
        self.failure = failure(self._block, t, int(self._filter.cause), self._arrays["scales"][:, 0])


def export_bank(bank: Bank) -> Source:
    """A library that runs the observers of a bank over any recording."""
    tables = {block.name: hoisted(block.name, functions(block, (), bank.staged(block))) for block in bank.exported}
    return export_blocks(
        tables=tables,
        blocks=bank.exported,
        sizes=bank.sizes(),
        named=bank.named(),
        lists={"Observers": bank.observers, "Everything": bank.exported},
        files=("front.hpp", "filter.cpp"),
    )
