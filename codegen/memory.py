"""The arrays that the kernel works on: numbers × lanes, one vector of lanes after the other."""

from __future__ import annotations

import ctypes
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..model.arrays import Array
from ..model.block import Block
from .loop import Loop
from .structures import Batch, FrontPart, Part, Runs

# grid points of a shared truth at a time: its rows stay in the nearest cache
_TILE = 64
_ALIGNMENT = 64  # bytes

Whole = NDArray[np.int64]


@dataclass(frozen=True)
class Grid:
    """The time grid of a run, in whole steps of `h`."""

    h: float
    steps: int
    record: int  # steps per recorded point
    hold: int  # steps per noise sample; 0: no noise
    window: int  # first grid point whose errors count
    pulses: tuple[tuple[int, int], ...] = ()  # first step on, first step off

    def of(self, block: Block) -> Grid:
        """The grid of the points at which the errors of `block` count: the samples, if it moves at them only."""
        if not block.sampled or not self.hold:
            return self
        return replace(
            self, h=self.h * self.hold, steps=self.steps // self.hold, window=-(-self.window // self.hold), hold=1
        )

    def halved(self) -> Grid:
        """The same times in steps of h/2."""
        return Grid(
            h=self.h / 2,
            steps=2 * self.steps,
            record=2 * self.record,
            hold=2 * self.hold,
            window=2 * self.window,
            pulses=tuple((2 * on, 2 * off) for on, off in self.pulses),
        )


@dataclass(frozen=True)
class Compiled:
    """What a library says of itself: runs in one vector, numbers in a row of the truth, constants of each Block."""

    lanes: int
    row: int
    constants: Mapping[str, int]


class Memory:
    """All that one batch needs; `batch` is what the kernel is given."""

    def __init__(
        self,
        loop: Loop,
        compiled: Compiled,
        grid: Grid,
        seeds: NDArray[np.uint64],
        parameters: Mapping[str, ArrayLike],
        observers: Sequence[str],
        record: bool,
    ) -> None:
        self._loop, self._lanes, self._observers, self.runs = loop, compiled.lanes, observers, len(seeds)
        used = [block for block in loop.blocks if block not in loop.observers or block.name in observers]
        values = {
            b.name: np.broadcast_to(np.asarray(parameters[b.name], dtype=float), (self.runs, len(b.p))) for b in used
        }
        truth = values[loop.truth.name]
        # a batch that records has room for the truth of each run
        same = bool((truth == truth[:1]).all()) and not loop.noisy
        self._shared = not record and self.runs > self._lanes and same
        self._vectors = -(-self.runs // self._lanes)
        fronts, self._front_of = _distinct_fronts(loop, values, observers)
        self._places, total = self._arrangement(used, compiled, len(fronts), record)
        # one more vector for a truth that all share
        self._numbers = aligned((self._vectors + self._shared, total, self._lanes))
        # spare lanes repeat the last run
        members = np.minimum(np.arange(len(self._numbers) * self._lanes) % (self._vectors * self._lanes), self.runs - 1)
        for name, given in [*values.items(), *((f"front {i}", given) for i, given in enumerate(fronts))]:
            self._fill(name, given[members])
        points = grid.steps // grid.record + 1 if record else 0
        recorded = used[:-1]  # all but the score
        self.records = {
            (block.name, key): np.full((self.runs, points, len(getattr(block, key))), np.nan)
            for block in recorded
            for key in ("x", "y")
        }
        self._failed = np.full((len(self._numbers), len(loop.blocks), self._lanes), -1, dtype=np.int64)
        self._cause = np.zeros_like(self._failed)
        self._seeds = seeds[members]
        self._rows = np.zeros(_TILE * compiled.row)
        edges = np.array(grid.pulses or [(0, 0)] * len(loop.pulses), dtype=np.int64).reshape(-1, 2)
        self._edges = np.ascontiguousarray(edges.T)
        self._tables = [self._table(vector, len(fronts), record) for vector in range(len(self._numbers))]
        self._runs = (Runs * len(self._tables))(*self._tables)
        self.batch = Batch(h=grid.h, steps=grid.steps, hold=grid.hold, window=grid.window, record=grid.record)
        self.batch.pulse_on, self.batch.pulse_off = (edge.ctypes.data for edge in self._edges)
        self.batch.n_runs, self.batch.runs = self._vectors, self._runs
        self.batch.rows, self.batch.tile = self._rows.ctypes.data, _TILE
        if self._shared:
            self.batch.truth = ctypes.pointer(self._runs[self._vectors])

    def numbers(self, block: Block, key: str) -> Array:
        """(runs × numbers) of an array of `block`."""
        place = self._places.get((block.name, key), slice(0, 0))
        vectors = self._numbers[:, place].transpose(0, 2, 1)
        return vectors.reshape(vectors.shape[0] * self._lanes, vectors.shape[2])[self._lanes_of(block)]

    def failed(self, block: Block) -> Whole:
        """(runs) grid point of the failure of `block`, or −1."""
        return self._state(self._failed, block)

    def cause(self, block: Block) -> Whole:
        """(runs) what failed, counted over x, y, domain."""
        return self._state(self._cause, block)

    def _state(self, array: Whole, block: Block) -> Whole:
        return array[:, self._loop.blocks.index(block)].ravel()[self._lanes_of(block)]

    def _lanes_of(self, block: Block) -> Whole:
        """Where the runs of a block are, counted in lanes."""
        if self._shared and block is self._loop.truth:
            return np.full(self.runs, self._vectors * self._lanes, dtype=np.int64)
        return np.arange(self.runs, dtype=np.int64)

    def _arrangement(
        self, used: Sequence[Block], compiled: Compiled, fronts: int, record: bool
    ) -> tuple[dict[tuple[str, str], slice], int]:
        """Where each array is within a vector, and how many numbers there are."""
        loop = self._loop
        sizes = {("", "noise"): len(loop.noise)}
        for block in used:
            sizes[block.name, "p"], sizes[block.name, "c"] = len(block.p), compiled.constants[block.name]
            sizes[block.name, "x"], sizes[block.name, "scales"] = len(block.x), len(block.x) + len(block.y)
            if block in loop.observers:
                sizes[block.name, "sums"] = len(loop.score.x)
            if record:
                sizes[block.name, "guards"] = len(block.guards)
        for i in range(fronts):
            sizes[f"front {i}", "p"] = len(loop.bank.front.p)
            sizes[f"front {i}", "c"] = compiled.constants[loop.bank.front.name]
            sizes[f"front {i}", "c_near"] = compiled.constants[(loop.bank.near or loop.bank.front).name]
        # an empty array takes one number, so that it has an address of its own
        ends = [0, *itertools.accumulate(max(1, size) for size in sizes.values())]
        starts = zip(sizes.items(), ends, strict=False)
        return {key: slice(start, start + size) for (key, size), start in starts}, ends[-1]

    def _fill(self, name: str, given: Array) -> None:
        vectors = given.reshape(len(self._numbers), self._lanes, given.shape[1])
        self._numbers[:, self._places[name, "p"]] = vectors.transpose(0, 2, 1)

    def _table(self, vector: int, fronts: int, record: bool) -> Runs:
        start = self._lanes * vector
        return Runs(
            n=max(1, min(self._lanes, self.runs - start)),
            seeds=self._seeds[start:].ctypes.data,
            parts=(Part * len(self._loop.blocks))(*(self._part(vector, block, record) for block in self._loop.blocks)),
            fronts=(FrontPart * fronts)(
                *(
                    FrontPart(*(self._address(vector, f"front {i}", key) for key in ("p", "c", "c_near")))
                    for i in range(fronts)
                )
            ),
            n_fronts=fronts,
            noise=self._address(vector, "", "noise"),
        )

    def _part(self, vector: int, block: Block, record: bool) -> Part:
        index = self._loop.blocks.index(block)
        arrays = {key: self._address(vector, block.name, key) for key in ("p", "c", "x", "scales", "sums", "guards")}
        # the truth that all share fails for all
        owner = self._vectors if self._shared and block is self._loop.truth else vector
        part = Part(**arrays, front=self._front_of.get(block.name, 0))
        part.failed, part.cause = (array[owner, index].ctypes.data for array in (self._failed, self._cause))
        if record and (block.name, "x") in self.records:
            first = vector * self._lanes
            part.record_x, part.record_y = (self.records[block.name, key][first:].ctypes.data for key in ("x", "y"))
        return part

    def _address(self, vector: int, name: str, key: str) -> int | None:
        place = self._places.get((name, key))
        return None if place is None else int(self._numbers[vector, place.start].ctypes.data)


def _distinct_fronts(
    loop: Loop, values: Mapping[str, Array], observers: Sequence[str]
) -> tuple[list[Array], dict[str, int]]:
    """The different sets of numbers (runs × numbers) that observers have for the front, and whose is which."""
    distinct: dict[bytes, int] = {}
    fronts: list[Array] = []
    front_of: dict[str, int] = {}
    for block in loop.observers:
        if block.name in observers:
            numbers = values[block.name][:, [list(block.p).index(name) for name in loop.bank.front.p]]
            front_of[block.name] = distinct.setdefault(numbers.tobytes(), len(fronts))
            if front_of[block.name] == len(fronts):
                fronts.append(numbers)
    return fronts, front_of


def aligned(shape: tuple[int, ...]) -> Array:
    """Zeros at an address that whole vectors can be loaded from."""
    size = int(np.prod(shape)) * 8
    raw = np.zeros(size + _ALIGNMENT, dtype=np.uint8)
    start = -raw.ctypes.data % _ALIGNMENT
    return raw[start : start + size].view(np.float64).reshape(shape)
