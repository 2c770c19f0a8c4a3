"""Run a compiled closed loop many times at once, in slices that leave room for progress and Ctrl-C."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..model.arrays import Array
from ..model.block import Block
from .cache import BuildError
from .failure import Failure, failure
from .fingerprint import exported
from .loop import Loop
from .memory import Compiled, Grid, Memory, Whole
from .shared_library import load
from .structures import STRUCTURES, Batch
from .toolchain import NATIVE

# grid points × vectors of lanes in one call: well below 0.1 s
_SLICE = 20_000


@dataclass(frozen=True)
class Trace:
    """What one block did: recorded states and outputs (points × names), guard times, score; NaN after a failure."""

    x: Array
    y: Array
    guards: Mapping[str, float]
    score: Mapping[str, float]
    failure: Failure | None


@dataclass(frozen=True)
class Outcome:
    """What one block did in every run of a batch.

    sums: (runs × sums) of its score, NaN after a failure; failed: (runs) grid point of the failure or −1; cause: what
    failed, counted over x, y, domain.
    """

    sums: Array
    failed: Whole
    cause: Whole


class CompiledLoop:
    """A loop as a loaded library; nothing that its methods take recompiles it."""

    def __init__(self, loop: Loop, target: str = NATIVE) -> None:
        self.loop, self.target = loop, target
        source = exported(loop)
        self.path, self.dll = load(source, target)
        self.dll.hillobs_start.argtypes = (ctypes.POINTER(Batch),)
        self.dll.hillobs_advance.argtypes = (ctypes.POINTER(Batch), ctypes.c_int64)
        self.dll.hillobs_start.restype = self.dll.hillobs_advance.restype = None
        self.compiled = self._ask(source.description)

    def run(
        self,
        grid: Grid,
        seed: int,
        parameters: Mapping[str, ArrayLike],
        observers: Sequence[str],
        progress: Callable[[float], None] = lambda done: None,
    ) -> dict[str, Trace]:
        """One recorded run with the observers named; the truth and the sensors first.

        parameters: block name → values in the order of its `p`. progress is called with the fraction done.
        """
        memory = self._advanced(grid, [seed], parameters, observers, progress, record=True)
        return {block.name: self._trace(block, memory, grid) for block in self._recorded(observers)}

    def batch(
        self,
        grid: Grid,
        seeds: Sequence[int] | NDArray[np.uint64],
        parameters: Mapping[str, ArrayLike],
        observers: Sequence[str],
        progress: Callable[[float], None] = lambda done: None,
    ) -> dict[str, Outcome]:
        """One run per seed, on one time grid, of the truth and the observers named.

        parameters: block name → values in the order of its `p`, (numbers) or (runs × numbers). progress is called
        every 0.1 s or more often; what it raises ends the batch. A run's numbers do not depend on the others.
        """
        memory = self._advanced(grid, seeds, parameters, observers, progress, record=False)
        return {block.name: _outcome(block, memory, self.loop.truth) for block in self._recorded(observers)}

    def _advanced(
        self,
        grid: Grid,
        seeds: Sequence[int] | NDArray[np.uint64],
        parameters: Mapping[str, ArrayLike],
        observers: Sequence[str],
        progress: Callable[[float], None],
        record: bool,
    ) -> Memory:
        numbers = np.asarray(seeds, dtype=np.uint64)
        memory = Memory(self.loop, self.compiled, grid, numbers, parameters, observers, record)
        batch = memory.batch
        self.dll.hillobs_start(ctypes.byref(batch))
        while batch.k <= grid.steps and (memory.failed(self.loop.truth) < 0).any():
            self.dll.hillobs_advance(ctypes.byref(batch), batch.k + max(1, _SLICE // batch.n_runs))
            progress(min(batch.k, grid.steps) / grid.steps)
        return memory

    def _recorded(self, observers: Sequence[str]) -> list[Block]:
        by_name = {block.name: block for block in self.loop.observers}
        return [self.loop.truth, self.loop.sensors, *(by_name[name] for name in observers)]

    def _trace(self, block: Block, memory: Memory, grid: Grid) -> Trace:
        outcome, failed = _outcome(block, memory, self.loop.truth), None
        if (at := int(outcome.failed[0])) >= 0:
            failed = failure(block, at * grid.h, int(outcome.cause[0]), memory.numbers(block, "scales")[0])
        active = memory.numbers(block, "guards")[0] * grid.h
        return Trace(
            x=memory.records[block.name, "x"][0],
            y=memory.records[block.name, "y"][0],
            guards=dict(zip(block.guards, active.tolist(), strict=True)),
            score=dict(zip(self.loop.score.x, outcome.sums[0].tolist(), strict=False)),
            failure=failed,
        )

    def _ask(self, description: Mapping[str, Any]) -> Compiled:
        """What the library says of itself; BuildError if its sizes are not those of the loop."""
        constants = {entry["name"]: int(entry["constants"]) for entry in description["blocks"]}
        expected = [ctypes.sizeof(structure) for structure in STRUCTURES]
        for block in self.loop.exported:
            expected += [len(block.x), len(block.p), constants[block.name]]
            expected += [len(block.y), len(block.guards), len(block.domain)]
        found = (ctypes.c_int64 * (2 + len(expected)))()
        self.dll.hillobs_sizes(found)
        lanes, row, *rest = found
        if rest != expected:
            raise BuildError(f"{self.path} has other sizes than the loop it was built for.")
        return Compiled(lanes, row, constants)


@functools.lru_cache(maxsize=16)
def compile_loop(loop: Loop, target: str = NATIVE) -> CompiledLoop:
    """The loop as machine code for the processors of `target`, from the cache if it is there."""
    return CompiledLoop(loop, target)


def _outcome(block: Block, memory: Memory, truth: Block) -> Outcome:
    failed = memory.failed(block)
    # without a truth the sums of an observer measure nothing
    lost = (failed >= 0) | (memory.failed(truth) >= 0)
    sums = np.where(lost[:, None], np.nan, memory.numbers(block, "sums"))
    return Outcome(sums=sums, failed=failed, cause=memory.cause(block))
