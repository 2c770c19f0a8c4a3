"""One observer from sample to sample, as functions of its state: what every target calls."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from ...model.block import Block, BlockError, Symbols, symbols
from ..bank import Bank
from ..stepper import NODES, functions
from .clocks import without_clocks
from .floats import summed_apart, without_literals

# a measurement beyond it is none; fmax and fmin, in the inverse of a tendon, would make a number of what is none
_BEYOND = 1e30
# the time of the last sample, where an observer must know it
TIME = "t"


@dataclass(frozen=True)
class Clock:
    """Samples come every `period`, in the Block's unit of time, with so many RK4 steps in between; 0 of a sampled one.

    scales: name of a measurement or output → its unit, in that of the Block; 1 where there is none.
    """

    period: float
    substeps: int
    scales: Mapping[str, float]


@dataclass(frozen=True, eq=False)  # compared by identity: SX has no usable ==
class Follower:
    """The functions of one observer, and the names of their arrays in order.

        start  (p, u)           → s
        depart (s)              → m
        advance(i, p, s, u, m)  → m after step i, of `substeps`, on the way to the sample u
        arrive (d, p, s, u, m)  → s at the sample u, e, fine, limited; d: periods since the last sample

    s: states, then the measurements of the last sample and what the front made of them. m: how far the states have
    moved since, which a float tells better than where they are, and what the front makes of the measurements there.
    e: outputs, then guards. fine: 1 if all are numbers within their limits, u too; limited: 1 if a limit is active.
    """

    block: Block
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    estimates: tuple[str, ...]
    functions: Mapping[str, ca.Function]


def follower(bank: Bank, clock: Clock, prefix: str) -> Follower:
    """The only observer of a bank, as it follows samples: straight lines in between, as in codegen/recordings.

    The names of the functions begin with `prefix`. BlockError if it moves on a time grid, which samples are not.
    """
    (given,) = bank.observers
    if given.per_step:
        raise BlockError(f"{given.name}: it moves at the points of a time grid, and samples have none")
    parts = _Parts(bank, given, clock)
    between = {"advance": parts.advance()} if clock.substeps else {}
    made = {"start": parts.start(), "depart": parts.depart(), **between, "arrive": parts.arrive()}
    return Follower(
        block=parts.block,
        states=(*parts.block.x, *[TIME] * parts.absolute, *parts.seen),
        inputs=bank.measured,
        estimates=(*parts.block.y, *parts.block.guards),
        functions={
            role: without_literals(
                ca.Function(f"{prefix}_{role}", inputs, ca.cse([ca.densify(output) for output in outputs]))
            )
            for role, (inputs, outputs) in made.items()
        },
    )


# arguments and results of a function
Ends = tuple[list[ca.SX], list[ca.SX]]


class _Parts:
    """The functions of a Follower in its symbols."""

    def __init__(self, bank: Bank, given: Block, clock: Clock) -> None:
        self.bank, self.clock = bank, clock
        self.block, self.absolute = without_clocks(given)
        self.seen = (*bank.measured, *bank.front.y)
        self.roles = functions(self.block, (), self.seen)
        states, front = len(self.block.x), len(bank.front.y)
        sizes = [states, int(self.absolute), len(bank.measured), front]
        self.s, self.p, self.u = (
            ca.SX.sym(name, size) for name, size in zip("spu", (sum(sizes), len(self.block.p), sizes[2]), strict=True)
        )
        self.m, self.d, self.i = ca.SX.sym("m", states + front), ca.SX.sym("d"), ca.SX.sym("i")
        self.x, self.t, self.y, self.z = ca.vertsplit(self.s, [0, *itertools.accumulate(sizes)])
        self.moved, self.z_there = ca.vertsplit(self.m, [0, states, states + front])
        # the last sample, on the Block's clock
        self.begun = self.t if self.absolute else ca.SX(0)
        self.now = self.u / self._units(bank.measured)

    def start(self) -> Ends:
        """The state at the first sample."""
        first = ca.vertcat(self.now, self._told(self.now))
        time = ca.SX(int(self.absolute), 1)
        return [self.p, self.u], [ca.vertcat(self.roles["init"](0, self.p, [], first), time, first)]

    def depart(self) -> Ends:
        """No motion yet."""
        return [self.s], [ca.vertcat(ca.SX(len(self.block.x), 1), self.z)]

    def advance(self) -> Ends:
        """One RK4 step."""
        n = self.clock.substeps
        h = self.clock.period / n
        # y(τ) = y_{k−1} + (y_k − y_{k−1}) (i + c)/n
        line = {c: self.y + (self.now - self.y) * ((self.i + c) / n) for c in NODES}
        lengths = {c: self._told(there) if c else self.z_there for c, there in line.items()}
        stages = ca.horzcat(*(ca.vertcat(line[c], lengths[c]) for c in NODES))
        step = functions(_shifted(self.block), [*map(_base, self.block.x)], self.seen)["step"]
        moved, _ = step(self.begun + self.i * h, h, self.moved, self.p, self.x, stages)
        return [self.i, self.p, self.s, self.u, self.m], [ca.vertcat(moved, lengths[NODES[-1]])]

    def arrive(self) -> Ends:
        """What is told at a sample, and whether it can be."""
        there = ca.vertcat(self.now, self.z_there if self.clock.substeps else self._told(self.now))
        at, x = self.begun + self.d * self.clock.period, self.x + self.moved
        if "sample" in self.roles:
            x = summed_apart(self.roles["sample"], "x")(at, x, self.p, [], there)
        y, domain = self.roles["out"](at, x, self.p, [], there)
        guards = self.roles["watch"](at, x, self.p, [], there)
        scales = self.roles["scales"](self.clock.period / max(self.clock.substeps, 1), self.p)
        sane, within = ca.fabs(self.now) < _BEYOND, ca.fabs(ca.vertcat(x, y)) * scales <= 1
        fine = all_of(ca.vertsplit(ca.vertcat(sane, within, domain > 0)))
        arrived = ca.vertcat(x, at if self.absolute else ca.SX(0, 1), there)
        estimates = ca.vertcat(y * self._units(self.block.y), guards)
        arguments = [self.d, self.p, self.s, self.u, self.m]
        return arguments, [arrived, estimates, fine, any_of(ca.vertsplit(guards))]

    def _told(self, measured: ca.SX) -> ca.SX:
        """What the front makes of measurements."""
        front = self.bank.front
        numbers = self.p[[list(self.block.p).index(name) for name in front.p]]
        told: ca.SX = functions(front, (), self.bank.measured)["out"](self.begun, [], numbers, [], measured)[0]
        return told

    def _units(self, names: Iterable[str]) -> ca.SX:
        return ca.SX(ca.vertcat(*(self.clock.scales.get(name, 1.0) for name in names)))


def _base(state: str) -> str:
    return f"base.{state}"


def _shifted(block: Block) -> Block:
    """The observer in how far its states are from a base, which is held."""
    base = symbols(map(_base, block.x))
    x, there = block.x.vector(), block.x.vector() + base.vector()

    def shifted(entries: Symbols) -> Symbols:
        return Symbols(zip(entries, ca.vertsplit(ca.substitute(entries.vector(), x, there)), strict=True))

    return block.rewritten(
        lambda entries: shifted(entries) if entries else entries, u=Symbols({**block.u, **base}), x0=Symbols()
    )


def all_of(conditions: Sequence[ca.SX]) -> ca.SX:
    """1 if all are; a comparison with what is no number is 0."""
    result = ca.SX(1)
    for condition in conditions:
        result = ca.logic_and(result, condition)
    return result


def any_of(conditions: Sequence[ca.SX]) -> ca.SX:
    """1 if one is above 0."""
    result = ca.SX(0)
    for condition in conditions:
        result = ca.logic_or(result, condition > 0)
    return result
