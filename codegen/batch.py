"""Run a compiled closed loop many times at once, in slices that leave room for progress and Ctrl-C."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..model.block import Block
from .cache import BuildError
from .export import Loop, export_loop
from .library import Array, load

# runs of one batch: many share one truth, and its numbers fit in a cache
BATCH = 512
# grid points of 16 runs in one call: well below 0.1 s
_SLICE = 20_000
# grid points of a shared truth at a time: its rows stay in the nearest cache
_TILE = 64
_ALIGNMENT = 64  # bytes

Whole = NDArray[np.int64]


class _Part(ctypes.Structure):
    """`struct Part` of the kernel."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("p", "c", "x", "sums", "guards", "record_x", "record_y")),
        ("failed", ctypes.c_void_p),
        ("cause", ctypes.c_void_p),
        ("front", ctypes.c_int64),
    )


class _Runs(ctypes.Structure):
    """`struct Runs` of the kernel."""

    _fields_ = (
        ("n", ctypes.c_int64),
        ("seeds", ctypes.c_void_p),
        ("parts", ctypes.POINTER(_Part)),
        ("held", ctypes.c_void_p),
    )


class _Batch(ctypes.Structure):
    """`struct Batch` of the kernel."""

    _fields_ = (
        ("h", ctypes.c_double),
        *((name, ctypes.c_int64) for name in ("k", "steps", "hold", "window", "record")),
        ("pulse_on", ctypes.c_void_p),
        ("pulse_off", ctypes.c_void_p),
        ("n_runs", ctypes.c_int64),
        ("runs", ctypes.POINTER(_Runs)),
        ("truth", ctypes.POINTER(_Runs)),
        ("rows", ctypes.c_void_p),
        ("tile", ctypes.c_int64),
    )


@dataclass(frozen=True)
class Grid:
    """The time grid of a run, in whole steps of `h`."""

    h: float
    steps: int
    record: int  # steps per recorded point
    hold: int  # steps per noise sample; 0: no noise
    window: int  # first grid point whose errors count
    pulses: tuple[tuple[int, int], ...] = ()  # first step on, first step off


@dataclass(frozen=True)
class Failure:
    """Why and when a part of the loop has no more numbers: `name` is a state, an output or a domain of it."""

    time: float
    group: str  # "x", "y" or "domain"
    name: str


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
    failed, counted over x, y, domain; guards: (runs × guards) steps; x, y: (runs × points × names). The last three are
    empty unless the batch records.
    """

    sums: Array
    failed: Whole
    cause: Whole
    guards: Array
    x: Array
    y: Array


class CompiledLoop:
    """A loop as a loaded library; nothing that `run` takes recompiles it."""

    def __init__(self, loop: Loop, baseline: str = "native") -> None:
        self.loop = loop
        source = export_loop(loop)
        self.path, self._dll = load(source, baseline)
        self._dll.hillobs_start.argtypes = (ctypes.POINTER(_Batch),)
        self._dll.hillobs_advance.argtypes = (ctypes.POINTER(_Batch), ctypes.c_int64)
        self._dll.hillobs_start.restype = self._dll.hillobs_advance.restype = None
        described: Sequence[Mapping[str, int]] = source.description["blocks"]  # type: ignore[assignment]
        self._constants = [entry["constants"] for entry in described]
        self.lanes, self._row = self._check_sizes()

    def run(
        self,
        grid: Grid,
        seed: int,
        parameters: Mapping[str, Sequence[float]],
        observers: Sequence[str],
        progress: Callable[[float], None] = lambda done: None,
    ) -> dict[str, Trace]:
        """One recorded run with the observers named; the truth and the sensors first.

        parameters: block name → values in the order of its `p`. progress is called with the fraction done.
        """
        outcomes = self.batch(grid, [seed], parameters, observers, progress, record=True)
        return {block.name: self._trace(block, outcomes[block.name], grid) for block in self._chosen(observers)}

    def batch(
        self,
        grid: Grid,
        seeds: Sequence[int] | NDArray[np.uint64],
        parameters: Mapping[str, ArrayLike],
        observers: Sequence[str],
        progress: Callable[[float], None] = lambda done: None,
        record: bool = False,
    ) -> dict[str, Outcome]:
        """One run per seed on one time grid.

        parameters: block name → values in the order of its `p`, (numbers) or (runs × numbers). progress is called
        every 0.1 s or more often; what it raises ends the batch. A run's numbers do not depend on the others.
        """
        work = _Work(self, grid, np.asarray(seeds, dtype=np.uint64), parameters, observers, record)
        self._dll.hillobs_start(ctypes.byref(work.batch))
        per_call = max(1, _SLICE // work.batch.n_runs)
        while work.batch.k <= grid.steps and not work.lost():
            self._dll.hillobs_advance(ctypes.byref(work.batch), work.batch.k + per_call)
            progress(min(work.batch.k, grid.steps) / grid.steps)
        return {block.name: work.outcome(block) for block in self._chosen(observers)}

    def _chosen(self, observers: Sequence[str]) -> list[Block]:
        by_name = {block.name: block for block in self.loop.observers}
        return [self.loop.truth, self.loop.sensors, *(by_name[name] for name in observers)]

    def _trace(self, block: Block, outcome: Outcome, grid: Grid) -> Trace:
        failure, at = None, int(outcome.failed[0])
        if at >= 0:
            named = [(group, name) for group in ("x", "y", "domain") for name in getattr(block, group)]
            failure = Failure(at * grid.h, *named[int(outcome.cause[0])])
        return Trace(
            x=outcome.x[0],
            y=outcome.y[0],
            guards=dict(zip(block.guards, (outcome.guards[0] * grid.h).tolist(), strict=True)),
            score=dict(zip(self.loop.score.x, outcome.sums[0].tolist(), strict=False)),
            failure=failure,
        )

    def _check_sizes(self) -> tuple[int, int]:
        """Lanes and numbers per row; BuildError if the library has other sizes than the loop."""
        structures = [ctypes.sizeof(structure) for structure in (_Batch, _Runs, _Part)]
        expected = []
        for block, constants in zip(self.loop.blocks, self._constants, strict=True):
            expected += [len(block.x), len(block.p), constants, len(block.y), len(block.guards), len(block.domain)]
        found = (ctypes.c_int64 * (5 + len(expected)))()
        self._dll.hillobs_sizes(found)
        lanes, row, *rest = found
        if rest != [*structures, *expected]:
            raise BuildError(f"{self.path} has other sizes than the loop it was built for.")
        return lanes, row

    @functools.cached_property
    def fronts(self) -> dict[str, tuple[str, list[int]]]:
        """What each observer computes from the measurements alone, as text, and which of its parameters that takes."""
        return {block.name: _front(block) for block in self.loop.observers}


def _front(block: Block) -> tuple[str, list[int]]:
    expressions = block.front.vector()
    used = {symbol.element_hash() for symbol in ca.symvar(expressions)}
    places = [i for i, symbol in enumerate(block.p.values()) if symbol.element_hash() in used]
    ports = [(name, symbol) for name, symbol in block.u.items() if symbol.element_hash() in used]
    inputs = [*(symbol for _, symbol in ports), *(list(block.p.values())[i] for i in places)]
    names = [list(block.front), [name for name, _ in ports], [list(block.p)[i] for i in places]]
    return f"{names} {ca.Function('front', inputs, [expressions]).serialize()}", places


class _Work:
    """The arrays that the kernel works on, as many vectors of lanes as the runs need."""

    def __init__(
        self,
        compiled: CompiledLoop,
        grid: Grid,
        seeds: NDArray[np.uint64],
        parameters: Mapping[str, ArrayLike],
        observers: Sequence[str],
        record: bool,
    ) -> None:
        loop, lanes = compiled.loop, compiled.lanes
        self.loop, self.n = loop, len(seeds)
        values = {
            block.name: np.atleast_2d(np.asarray(parameters[block.name], dtype=float)) for block in loop.blocks
        }
        # a batch that records has room for the truth of each run
        shared = not record and self.n > lanes and bool((values["truth"] == values["truth"][:1]).all())
        vectors = -(-self.n // lanes)
        # spare lanes repeat the last run; one more vector for a truth that all share
        self.members = np.minimum(np.arange((vectors + shared) * lanes) % (vectors * lanes), self.n - 1)
        self.seeds = seeds[self.members]
        self.vectors, self.shared = vectors, shared
        used = {loop.truth.name, loop.sensors.name, loop.score.name, *observers}
        self.rows: dict[tuple[str, str], slice] = {}
        total = 0
        for block, constants in zip(loop.blocks, compiled._constants, strict=True):
            if block.name not in used:
                continue
            sizes = {"p": len(block.p), "c": constants, "x": len(block.x) + 1}
            sizes |= {"sums": len(loop.score.x)} if block.name in observers else {}
            sizes |= {"guards": len(block.guards)} if record else {}
            for key, size in sizes.items():
                self.rows[block.name, key] = slice(total, total + size)
                total += size
        self.rows["", "held"] = slice(total, total + len(loop.held))
        total += len(loop.held)
        self.numbers = _aligned((vectors + shared, total, lanes))
        for block in loop.blocks:
            if block.name in used:
                given = np.broadcast_to(values[block.name], (self.n, len(block.p)))[self.members]
                given = given.reshape(vectors + shared, lanes, len(block.p))
                self.numbers[:, self.rows[block.name, "p"]] = given.transpose(0, 2, 1)
        points = grid.steps // grid.record + 1 if record else 0
        self.records = {
            (block.name, key): np.full((self.n, points, len(getattr(block, key))), np.nan)
            for block in loop.blocks
            if block.name in used and block is not loop.score
            for key in ("x", "y")
        }
        self.failed = np.full((vectors + shared, len(loop.blocks), lanes), -1, dtype=np.int64)
        self.cause = np.zeros_like(self.failed)
        self.row = np.zeros(_TILE * compiled._row)
        edges = np.array(grid.pulses or [(0, 0)] * len(loop.pulses), dtype=np.int64).reshape(-1, 2)
        self.on, self.off = np.ascontiguousarray(edges[:, 0]), np.ascontiguousarray(edges[:, 1])
        fronts = _same_fronts(compiled, values, observers)
        self._keep = [
            (_Part * len(loop.blocks))(
                *(self._part(v, i, block, fronts, record) for i, block in enumerate(loop.blocks))
            )
            for v in range(vectors + shared)
        ]
        runs = [
            _Runs(
                n=min(lanes, self.n - v * lanes) if v < vectors else 1,
                seeds=self.seeds.ctypes.data + 8 * lanes * v,
                parts=parts,
                held=self._address(v, "", "held"),
            )
            for v, parts in enumerate(self._keep)
        ]
        self.table = (_Runs * len(runs))(*runs)
        self.batch = _Batch(
            h=grid.h, steps=grid.steps, hold=grid.hold, window=grid.window, record=grid.record, n_runs=vectors
        )
        self.batch.pulse_on, self.batch.pulse_off = self.on.ctypes.data, self.off.ctypes.data
        self.batch.runs, self.batch.rows, self.batch.tile = self.table, self.row.ctypes.data, _TILE
        if shared:
            self.batch.truth = ctypes.pointer(self.table[vectors])

    def lost(self) -> bool:
        """Has the truth of every run failed?"""
        return bool((self._state(self.failed, self.loop.truth) >= 0).all())

    def outcome(self, block: Block) -> Outcome:
        """What the kernel has left in the arrays."""
        failed = self._state(self.failed, block)
        sums = self._numbers(block, "sums")
        lost = (failed >= 0) | (self._state(self.failed, self.loop.truth) >= 0)
        return Outcome(
            sums=np.where(lost[:, None], np.nan, sums),
            failed=failed,
            cause=self._state(self.cause, block),
            guards=self._numbers(block, "guards"),
            x=self.records[block.name, "x"],
            y=self.records[block.name, "y"],
        )

    def _numbers(self, block: Block, key: str) -> Array:
        """(runs × numbers) of one array of the kernel; of a truth that all share, one for all."""
        rows = self.rows.get((block.name, key), slice(0, 0))
        vectors, _, lanes = self.numbers.shape
        each = self.numbers[:, rows].transpose(0, 2, 1).reshape(vectors * lanes, rows.stop - rows.start)
        return each[self._lanes(block)]

    def _state(self, array: Whole, block: Block) -> Whole:
        flat = array[:, list(self.loop.blocks).index(block)].ravel()
        return flat[self._lanes(block)]

    def _lanes(self, block: Block) -> Whole:
        """Where the runs of a block are."""
        if self.shared and block is self.loop.truth:
            return np.full(self.n, self.vectors * self.numbers.shape[2], dtype=np.int64)
        return np.arange(self.n, dtype=np.int64)

    def _address(self, vector: int, block: str, key: str) -> int | None:
        rows = self.rows.get((block, key))
        return None if rows is None else int(self.numbers[vector, rows.start :].ctypes.data)

    def _part(
        self, vector: int, index: int, block: Block, fronts: Mapping[str, int], record: bool
    ) -> _Part:
        lanes = self.numbers.shape[2]
        part = _Part(front=fronts.get(block.name, 0))
        for key in ("p", "c", "x", "sums", "guards"):
            setattr(part, key, self._address(vector, block.name, key))
        own = len(self.numbers) - 1 if self.shared and block is self.loop.truth else vector
        part.failed = self.failed[own, index].ctypes.data
        part.cause = self.cause[own, index].ctypes.data
        if record and (block.name, "x") in self.records:
            part.record_x = self.records[block.name, "x"][vector * lanes :].ctypes.data
            part.record_y = self.records[block.name, "y"][vector * lanes :].ctypes.data
        return part


def _same_fronts(compiled: CompiledLoop, values: Mapping[str, Array], observers: Sequence[str]) -> dict[str, int]:
    """For each observer, the first one whose front gives the same numbers in every run."""
    first: dict[tuple[str, bytes], int] = {}
    result = {}
    for i, block in enumerate(compiled.loop.observers):
        if block.name in observers:
            text, places = compiled.fronts[block.name]
            own = values[block.name][:, places]
            own = own[:1] if (own == own[:1]).all() else own
            result[block.name] = first.setdefault((text, own.tobytes()), i)
    return result


def _aligned(shape: tuple[int, ...]) -> Array:
    """Zeros at an address that whole vectors can be loaded from."""
    size = int(np.prod(shape)) * 8
    raw = np.zeros(size + _ALIGNMENT, dtype=np.uint8)
    start = -raw.ctypes.data % _ALIGNMENT
    return raw[start : start + size].view(np.float64).reshape(shape)
