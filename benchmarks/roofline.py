"""How near the kernel is to what the core can do: operations counted from the graph, peaks measured."""

from __future__ import annotations

import ctypes
import functools
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import casadi as ca

from hillobs.codegen.stepper import STAGES
from hillobs.codegen.toolchain import NATIVE, TARGETS, compile_library, find_compiler
from hillobs.model.block import Block

from .problem import Problem
from .timing import clock

PEAKS = ("multiply_add", "divide", "square_root")
_FLOPS = {ca.OP_ADD: 1, ca.OP_SUB: 1, ca.OP_MUL: 1, ca.OP_SQ: 1, ca.OP_TWICE: 1, ca.OP_DIV: 1, ca.OP_INV: 1}
_DIVISIONS = (ca.OP_DIV, ca.OP_INV)
_SOURCE = Path(__file__).with_name("peaks.cpp")
_TURNS = 4_000_000


@dataclass(frozen=True)
class Work:
    """Operations of one closed-loop step: `flops` are all of them, divisions and roots included."""

    flops: int
    divisions: int
    roots: int

    def __add__(self, other: Work) -> Work:
        return Work(self.flops + other.flops, self.divisions + other.divisions, self.roots + other.roots)

    def times(self, n: int) -> Work:
        """So many of them."""
        return Work(n * self.flops, n * self.divisions, n * self.roots)


def work_of(f: ca.Function) -> Work:
    """The operations in the graph of a function."""
    counts = Counter(f.instruction_id(k) for k in range(f.n_instructions()))
    roots = counts[ca.OP_SQRT]
    flops = sum(counts[operation] for operation in _FLOPS) + roots
    return Work(flops, sum(counts[operation] for operation in _DIVISIONS), roots)


def work_of_a_step(of: Problem, with_truth: bool) -> Work:
    """What the kernel does for one run and step: sensors, tendons, observers and their scores, and the truth's."""

    def role(name: str, block: Block) -> Work:
        table = of.loop.compiled(block)
        # a score without sums has nothing to do
        return work_of(table[name]) if name in table else Work(0, 0, 0)

    total = role("out", of.loop.sensors).times(STAGES) + role("out", of.loop.bank.near or of.loop.bank.front)
    for block in of.observers:
        total += role("step", block) + role("out", block) + role("each", of.loop.score)
    return total + role("step", of.loop.truth) + role("out", of.loop.truth) if with_truth else total


def peak(name: str) -> float:
    """Operations per CPU second of the core at its best, measured now."""
    measured = getattr(_library(), name)
    done: list[float] = []
    result = ctypes.c_double()
    seconds = clock(lambda: done.append(measured(_TURNS, 1.0, 0.5, ctypes.byref(result))))
    return done[0] / seconds


@functools.cache
def _library() -> ctypes.CDLL:
    with tempfile.TemporaryDirectory() as folder:
        path = compile_library(_SOURCE.read_text(encoding="utf-8"), Path(folder), find_compiler(), TARGETS[NATIVE])
        library = ctypes.CDLL(str(path))
    for name in PEAKS:
        getattr(library, name).argtypes = (ctypes.c_int64, ctypes.c_double, ctypes.c_double, ctypes.c_void_p)
        getattr(library, name).restype = ctypes.c_double
    return library
