"""Our kernel: noise drawn, errors summed at every step, checks; unless a row says that it leaves them out."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from hillobs.codegen.batch import CompiledLoop
from hillobs.codegen.toolchain import NATIVE, find_compiler
from hillobs.observers.score import score

from ..problem import FULL_SCORE, Problem, problem, states
from ..roofline import work_of_a_step
from . import AbsentError, Contender

_RUNS = 256
# what differs from run to run where each has a truth of its own
_START = "initial.x1"


@dataclass(frozen=True)
class Variant:
    """One way of running our kernel. By default as a sweep of gains: one truth for all runs, 21 error sums."""

    words: str = ""
    own_truth: bool = False  # a truth per run, as in a sweep over the plant
    all_measures: bool = False  # of `hillobs simulate`, activations too
    bare: bool = False  # without error sums and noise of our own, as the peers
    in_code: bool = False  # fixed numbers written into the code, as in a long sweep
    compiler: str = ""  # another one than usual
    target: str = NATIVE
    runs: int = _RUNS

    def __call__(self, of: Problem) -> Contender:
        """The row of the table."""
        if self.compiler and shutil.which(self.compiler) is None:
            raise AbsentError(f"{self.compiler} is not installed")
        if self.all_measures:
            of = problem(FULL_SCORE)
        if self.bare:
            of = replace(of, loop=replace(of.loop, score=score((), ())), numbers={**of.numbers, "score": []})
            of = replace(of, grid=replace(of.grid, hold=0))
        return self._of(self._with_numbers_in_code(of) if self.in_code else of)

    def _of(self, of: Problem) -> Contender:
        with _compiler(self.compiler):
            compiled = CompiledLoop(of.loop, self.target)
            name = ", ".join(filter(None, [f"hillobs, {_compiler_name()}", self.words]))
        seeds = np.arange(self.runs, dtype=np.uint64)
        given: dict[str, ArrayLike] = {**of.numbers}
        if self.own_truth:
            truth = np.repeat(np.array([of.numbers[of.loop.truth.name]]), self.runs, axis=0)
            # one start that differs is enough
            truth[0, list(of.loop.truth.p).index(_START)] += 1e-6
            given[of.loop.truth.name] = truth
        return Contender(
            name,
            self.runs,
            of.grid.steps,
            lambda: compiled.batch(of.grid, seeds, given, of.names),
            lambda: states(of, of.grid.steps, compiled),
            operations=work_of_a_step(of, with_truth=self.own_truth),
        )

    def _with_numbers_in_code(self, of: Problem) -> Problem:
        names = {block.name: list(block.p) for block in of.loop.blocks}
        left = {of.loop.truth.name: [_START]} if self.own_truth else {}
        every = {name: dict(zip(names[name], numbers, strict=True)) for name, numbers in of.numbers.items()}
        fixed = {
            name: {n: value for n, value in numbers.items() if n not in left.get(name, [])}
            for name, numbers in every.items()
        }
        loop = of.loop.with_numbers(fixed)
        return replace(of, loop=loop, numbers={b.name: [every[b.name][n] for n in b.p] for b in loop.blocks})


def variants() -> Iterator[Callable[[Problem], Contender]]:
    """Our rows."""
    yield Variant()
    yield Variant("own code", in_code=True)
    yield Variant("a truth per run", own_truth=True)
    yield Variant("a truth per run, own code", own_truth=True, in_code=True)
    yield Variant("as the peers", own_truth=True, in_code=True, bare=True)
    yield Variant("all measures", all_measures=True)
    yield Variant("all measures, own code", all_measures=True, in_code=True)
    yield Variant(compiler="clang++")
    yield Variant("a truth per run, own code", own_truth=True, in_code=True, compiler="clang++")
    yield Variant("scalar", target="scalar", runs=4)


def _compiler_name() -> str:
    """`gcc 12.2.0` and the like."""
    compiler = find_compiler()
    number = re.search(r"\d+\.\d+(\.\d+)?", compiler.version)
    return f"{compiler.kind} {number[0] if number else ''}".strip()


@contextmanager
def _compiler(command: str) -> Iterator[None]:
    """Libraries are compiled by `command`, if one is named."""
    before = os.environ.get("CXX")
    if command:
        os.environ["CXX"] = command
    try:
        yield
    finally:
        if before is None:
            os.environ.pop("CXX", None)
        else:
            os.environ["CXX"] = before
