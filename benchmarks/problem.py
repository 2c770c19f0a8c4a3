"""What every contender simulates: the closed loop of `paper-noisy` with its three observers, 31 states."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from hillobs.codegen.batch import CompiledLoop, compile_loop
from hillobs.codegen.loop import Loop
from hillobs.codegen.memory import Grid
from hillobs.model.arrays import Array
from hillobs.model.block import Block
from hillobs.model.symbols import QUANTITIES, hat
from hillobs.model.wiring import wire
from hillobs.observers import ESTIMATES, PAPER
from hillobs.observers.score import MEASURES
from hillobs.studies.scenarios.prepare import prepare

SCENARIO = "paper-noisy"
# what an observer estimates itself, and the one measure of it that a sweep of RMSE needs: 21 sums for three observers
LEAN_SCORE = tuple(name for name in QUANTITIES if hat(name) in ESTIMATES), ("rmse",)
FULL_SCORE = tuple(QUANTITIES), tuple(MEASURES)


@dataclass(frozen=True, eq=False)  # compared by identity: arrays have no truth value
class Problem:
    """A loop with all its numbers. `x0` holds the 31 states at the start: the truth's, then each observer's."""

    loop: Loop
    grid: Grid
    numbers: Mapping[str, list[float]]
    x0: Array

    @property
    def observers(self) -> tuple[Block, ...]:
        """The observers that take part."""
        return tuple(block for block in self.loop.observers if block.name in PAPER)

    @property
    def names(self) -> list[str]:
        """Their names."""
        return [block.name for block in self.observers]

    def times(self, steps: int) -> Array:
        """When each step begins."""
        return np.arange(steps, dtype=np.float64) * np.float64(self.grid.h)

    def front(self, block: Block) -> list[float]:
        """The numbers of a front `block`: what the observers have of the same names."""
        whose = self.observers[0]
        return [self.numbers[whose.name][list(whose.p).index(name)] for name in block.p]


@functools.cache
def problem(score: tuple[tuple[str, ...], tuple[str, ...]] = LEAN_SCORE) -> Problem:
    """The scenario as shipped, scored by quantities and measures."""
    prepared = prepare(SCENARIO, None, {}, *score)
    loop, given = prepared.loop, prepared.scenario.given
    numbers = {block.name: prepared.paths.values(block, given) for block in loop.blocks}
    blank = Problem(loop, prepared.grid, numbers, np.empty(0))
    return replace(blank, x0=states(blank, 0))


def states(of: Problem, steps: int, compiled: CompiledLoop | None = None) -> Array:
    """The 31 states of our own kernel after so many steps without noise: what every contender must reach."""
    grid = replace(of.grid, steps=max(1, steps), record=max(1, steps), hold=0)
    traces = (compiled or compile_loop(of.loop)).run(grid, 0, of.numbers, of.names)
    return np.concatenate([traces[block.name].x[min(1, steps)] for block in (of.loop.truth, *of.observers)])


def noise(of: Problem, runs: int, steps: int) -> Array:
    """(samples × channels × runs) of the kernel's own noise for the seeds 0, 1, …."""
    samples = -(-steps // of.grid.hold)
    values = np.empty((runs, len(of.loop.noise), samples))
    draw = compile_loop(of.loop).dll.hillobs_noise
    draw.argtypes = (ctypes.c_uint64, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_int64, ctypes.c_void_p)
    for seed, channel in np.ndindex(values.shape[:2]):
        draw(seed, channel, 0, samples, values[seed, channel].ctypes.data)
    return np.ascontiguousarray(values.transpose(2, 1, 0))


def whole(of: Problem) -> tuple[Block, list[float]]:
    """Truth, sensors, tendons and observers wired into one Block, and its numbers. Inputs: t and the noise."""
    loop = of.loop
    sensed = {f"{loop.sensors.name}.{port}": f"{loop.truth.name}.{port}" for port in loop.seen}
    noise = {f"{loop.sensors.name}.{port}": port for port in loop.noise}
    front = {f"{loop.bank.front.name}.{port}": f"{loop.sensors.name}.{port}" for port in loop.bank.front.u}
    seen = {
        f"{block.name}.{port}": f"{loop.bank.front.name if port in loop.bank.front.y else loop.sensors.name}.{port}"
        for block in of.observers
        for port in block.u
    }
    # the scenario has no pulses
    idle = {f"{loop.truth.name}.{port}": 0.0 for port in loop.pulses}
    time = {f"{loop.truth.name}.t": "t"}
    parts = [loop.truth, loop.sensors, loop.bank.front, *of.observers]
    external = {"t": "t", **dict.fromkeys(loop.noise, "held")}
    block = wire("whole", parts, {**time, **idle, **sensed, **noise, **front, **seen}, external)
    numbers = [*of.numbers[loop.truth.name], *of.numbers[loop.sensors.name], *of.front(loop.bank.front)]
    return block, [*numbers, *(number for name in of.names for number in of.numbers[name])]


def right_hand_side(of: Problem) -> tuple[ca.Function, list[float]]:
    """ẋ = f(t, x, p, w) of the whole as it is written, nothing shared and nothing folded, and the numbers p."""
    block, numbers = whole(of)
    w = ca.vertcat(*(block.u[name] for name in of.loop.noise))
    given = [block.u.t, block.x.vector(), block.p.vector(), w]
    return ca.Function("whole", given, [block.dx.vector()], ["t", "x", "p", "w"], ["dx"]), numbers
