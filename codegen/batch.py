"""Run a compiled closed loop: one run with recording, in slices that leave room for progress and Ctrl-C."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..model.block import Block
from .cache import BuildError
from .export import Loop, export_loop
from .library import Array, Library

# grid points per slice: well below 0.1 s
_SLICE = 2000

_Doubles = ctypes.POINTER(ctypes.c_double)
_Integers = ctypes.POINTER(ctypes.c_int64)


class _Part(ctypes.Structure):
    """`struct Part` of the kernel."""

    _fields_ = (
        ("block", ctypes.c_int64),
        *((name, _Doubles) for name in ("p", "x", "y", "guards", "score", "record_x", "record_y")),
        ("failed", ctypes.c_int64),
        ("cause", ctypes.c_int64),
    )


class _Run(ctypes.Structure):
    """`struct Run` of the kernel."""

    _fields_ = (
        ("h", ctypes.c_double),
        ("seed", ctypes.c_uint64),
        *((name, ctypes.c_int64) for name in ("k", "steps", "hold", "window", "record")),
        ("pulse_on", _Integers),
        ("pulse_off", _Integers),
        ("p_score", _Doubles),
        ("parts", ctypes.POINTER(_Part)),
        ("n_parts", ctypes.c_int64),
        ("held", _Doubles),
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


class CompiledLoop:
    """A loop as a loaded library; nothing that `run` takes recompiles it."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop
        self.library = Library(export_loop(loop))
        dll = self.library.dll
        dll.hillobs_start.argtypes = (ctypes.POINTER(_Run),)
        dll.hillobs_advance.argtypes = (ctypes.POINTER(_Run), ctypes.c_int64)
        dll.hillobs_start.restype = dll.hillobs_advance.restype = None
        self._check_sizes()

    def run(
        self,
        grid: Grid,
        seed: int,
        parameters: Mapping[str, Sequence[float]],
        observers: Sequence[str],
        progress: Callable[[float], None] = lambda done: None,
    ) -> dict[str, Trace]:
        """One run with the observers named; the truth first.

        parameters: block name → values in the order of its `p`. progress is called with the fraction done.
        """
        rows = {block.name: index for index, block in enumerate(self.loop.blocks)}
        names = [self.loop.truth.name, *observers]
        parts = [
            _Work(self.loop.blocks[rows[name]], rows[name], parameters[name], grid, len(self.loop.score.x))
            for name in names
        ]
        run = _Run(h=grid.h, seed=seed, steps=grid.steps, hold=grid.hold, window=grid.window, record=grid.record)
        edges = np.array(grid.pulses or [(0, 0)] * len(self.loop.pulses), dtype=np.int64).reshape(-1, 2)
        on, off = np.ascontiguousarray(edges[:, 0]), np.ascontiguousarray(edges[:, 1])
        score = np.array([*parameters[self.loop.score.name], 0.0])
        held = np.zeros(len(self.loop.held))
        run.pulse_on, run.pulse_off = on.ctypes.data_as(_Integers), off.ctypes.data_as(_Integers)
        run.p_score, run.held = score.ctypes.data_as(_Doubles), held.ctypes.data_as(_Doubles)
        table = (_Part * len(parts))(*(part.row() for part in parts))
        run.parts, run.n_parts = table, len(parts)

        self.library.dll.hillobs_start(ctypes.byref(run))
        while run.k <= grid.steps:
            self.library.dll.hillobs_advance(ctypes.byref(run), run.k + _SLICE)
            progress(min(run.k, grid.steps) / grid.steps)
        return {
            name: part.trace(row, self.loop.score, grid) for name, part, row in zip(names, parts, table, strict=True)
        }

    def _check_sizes(self) -> None:
        expected = [ctypes.sizeof(_Run), ctypes.sizeof(_Part)]
        for block in self.loop.blocks:
            expected += [len(block.x), len(block.y), len(block.guards), len(block.domain)]
        found = (ctypes.c_int64 * len(expected))()
        self.library.dll.hillobs_sizes(found)
        if list(found) != expected:
            raise BuildError(f"{self.library.path} has other sizes than the loop it was built for.")


class _Work:
    """The arrays that the kernel works on for one block."""

    def __init__(self, block: Block, index: int, p: Sequence[float], grid: Grid, n_score: int) -> None:
        points = grid.steps // grid.record + 1
        self.block, self.index = block, index
        self.arrays = {
            "p": np.array([*p, 0.0]),  # one more than needed: an array is never empty
            "x": np.zeros(len(block.x) + 1),
            "y": np.zeros(len(block.y) + 1),
            "guards": np.zeros(len(block.guards) + 1),
            "score": np.zeros(n_score),
            "record_x": np.full((points, len(block.x)), np.nan),
            "record_y": np.full((points, len(block.y)), np.nan),
        }

    def row(self) -> _Part:
        """The row of the kernel's table; it points into `arrays`."""
        pointers = {name: array.ctypes.data_as(_Doubles) for name, array in self.arrays.items()}
        return _Part(block=self.index, failed=-1, **pointers)

    def trace(self, row: _Part, score: Block, grid: Grid) -> Trace:
        """What the kernel has left in the arrays."""
        block, arrays = self.block, self.arrays
        failure = None
        if row.failed >= 0:
            named = [(group, name) for group in ("x", "y", "domain") for name in getattr(block, group)]
            failure = Failure(row.failed * grid.h, *named[row.cause])
        sums = np.full(len(score.x), np.nan) if failure else arrays["score"]
        return Trace(
            x=arrays["record_x"],
            y=arrays["record_y"],
            guards=dict(zip(block.guards, (arrays["guards"] * grid.h).tolist(), strict=False)),
            score=dict(zip(score.x, sums.tolist(), strict=True)),
            failure=failure,
        )
