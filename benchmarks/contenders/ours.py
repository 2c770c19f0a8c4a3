"""Our kernel: noise drawn, errors summed at every step, parameters as arguments."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike

from hillobs.codegen.batch import CompiledLoop
from hillobs.codegen.toolchain import find_compiler

from ..problem import FULL_SCORE, Problem, problem, states
from ..roofline import Work, work_of_a_step
from . import AbsentError, Contender

_RUNS = 256


def lean_score(of: Problem) -> Contender:
    """As a sweep runs it: one truth for all runs, 21 error sums."""
    return _contender(
        f"hillobs, {_compiler_name()}", of, CompiledLoop(of.loop), of.numbers, work_of_a_step(of, with_truth=False)
    )


def own_truth(of: Problem) -> Contender:
    """Every run with a truth of its own, as in a sweep over the plant."""
    name = of.loop.truth.name
    numbers = np.repeat(np.array([of.numbers[name]]), _RUNS, axis=0)
    # one start that differs is enough
    numbers[0, list(of.loop.truth.p).index("initial.x1")] += 1e-6
    given: dict[str, ArrayLike] = {**of.numbers, name: numbers}
    return _contender(
        f"hillobs, {_compiler_name()}, a truth per run",
        of,
        CompiledLoop(of.loop),
        given,
        work_of_a_step(of, with_truth=True),
    )


def full_score(of: Problem) -> Contender:
    """With all measures of `hillobs simulate`, activations too."""
    full = problem(FULL_SCORE)
    work = work_of_a_step(full, with_truth=False)
    return _contender(f"hillobs, {_compiler_name()}, all measures", full, CompiledLoop(full.loop), full.numbers, work)


def clang(of: Problem) -> Contender:
    """The same source by clang."""
    if shutil.which("clang++") is None:
        raise AbsentError("clang++ is not installed")
    with _compiler("clang++"):
        return _contender(
            f"hillobs, {_compiler_name()}", of, CompiledLoop(of.loop), of.numbers, work_of_a_step(of, with_truth=False)
        )


def scalar(of: Problem) -> Contender:
    """One run at a time."""
    name = f"hillobs, {_compiler_name()}, scalar"
    return _contender(
        name, of, CompiledLoop(of.loop, "scalar"), of.numbers, work_of_a_step(of, with_truth=False), runs=4
    )


def _contender(
    name: str, of: Problem, compiled: CompiledLoop, numbers: Mapping[str, ArrayLike], work: Work, runs: int = _RUNS
) -> Contender:
    seeds = np.arange(runs, dtype=np.uint64)
    return Contender(
        name,
        runs,
        of.grid.steps,
        lambda: compiled.batch(of.grid, seeds, numbers, of.names),
        lambda: states(of, of.grid.steps, compiled),
        operations=work,
    )


def _compiler_name() -> str:
    """`gcc 12.2.0` and the like."""
    compiler = find_compiler()
    number = re.search(r"\d+\.\d+(\.\d+)?", compiler.version)
    return f"{compiler.kind} {number[0] if number else ''}".strip()


@contextmanager
def _compiler(command: str) -> Iterator[None]:
    before = os.environ.get("CXX")
    os.environ["CXX"] = command
    try:
        yield
    finally:
        del os.environ["CXX"]
        if before is not None:
            os.environ["CXX"] = before
