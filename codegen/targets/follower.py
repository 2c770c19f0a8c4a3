"""One observer from sample to sample, as functions of its state: what every target calls."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
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
    block, absolute = without_clocks(given)
    seen = (*bank.measured, *bank.front.y)
    table, front = functions(block, (), seen), functions(bank.front, (), bank.measured)["out"]
    parts = [len(block.x), int(absolute), len(bank.measured), len(bank.front.y)]
    s, p, u = ca.SX.sym("s", sum(parts)), ca.SX.sym("p", len(block.p)), ca.SX.sym("u", len(bank.measured))
    x, t, y, z = ca.vertsplit(s, [0, *itertools.accumulate(parts)])
    d, i = ca.SX.sym("d"), ca.SX.sym("i")
    begun = t if absolute else ca.SX(0)
    p_front = p[[list(block.p).index(name) for name in bank.front.p]]
    now = u / ca.vertcat(*(clock.scales.get(name, 1.0) for name in bank.measured))

    def told(measured: ca.SX) -> ca.SX:
        """What the front makes of measurements."""
        return front(begun, [], p_front, [], measured)[0]

    m = ca.SX.sym("m", parts[0] + parts[3])
    delta, seen_from = ca.vertsplit(m, [0, parts[0], m.numel()])
    first = ca.vertcat(now, told(now))
    made = {
        "start": ([p, u], [ca.vertcat(table["init"](0, p, [], first), ca.SX(int(absolute), 1), first)]),
        "depart": ([s], [ca.vertcat(ca.SX(parts[0], 1), z)]),
    }
    if clock.substeps:
        h = clock.period / clock.substeps
        # y(τ) = y_{k−1} + (y_k − y_{k−1}) (i + c)/n
        line = {c: y + (now - y) * ((i + c) / clock.substeps) for c in NODES}
        made_of_it = {c: told(there) if c else seen_from for c, there in line.items()}
        stages = [ca.vertcat(line[c], made_of_it[c]) for c in NODES]
        moved, _ = functions(_shifted(block), [*map(_base, block.x)], seen)["step"](
            begun + i * h, h, delta, p, x, ca.horzcat(*stages)
        )
        made["advance"] = ([i, p, s, u, m], [ca.vertcat(moved, made_of_it[NODES[-1]])])
    there = ca.vertcat(now, seen_from if clock.substeps else told(now))
    at, x = begun + d * clock.period, x + delta
    if "sample" in table:
        x = summed_apart(table["sample"], "x")(at, x, p, [], there)
    y, domain = table["out"](at, x, p, [], there)
    guards = table["watch"](at, x, p, [], there)
    magnitudes = ca.fabs(ca.vertcat(x, y)) * table["scales"](clock.period / max(clock.substeps, 1), p)
    sane = ca.vertsplit(ca.fabs(now) < _BEYOND)
    fine = _all([*sane, *ca.vertsplit(magnitudes <= 1), *ca.vertsplit(domain > 0)])
    e = ca.vertcat(y * ca.vertcat(*(clock.scales.get(name, 1.0) for name in block.y)), guards)
    arrived = ca.vertcat(x, at if absolute else ca.SX(0, 1), there)
    made["arrive"] = ([d, p, s, u, m], [arrived, e, fine, _any(ca.vertsplit(guards))])
    return Follower(
        block=block,
        states=(*block.x, *[TIME] * absolute, *seen),
        inputs=bank.measured,
        estimates=(*block.y, *block.guards),
        functions={
            role: without_literals(
                ca.Function(f"{prefix}_{role}", inputs, ca.cse([ca.densify(output) for output in outputs]))
            )
            for role, (inputs, outputs) in made.items()
        },
    )


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


def _all(conditions: Sequence[ca.SX]) -> ca.SX:
    """1 if all are; a comparison with what is no number is 0."""
    result = ca.SX(1)
    for condition in conditions:
        result = ca.logic_and(result, condition)
    return result


def _any(conditions: Sequence[ca.SX]) -> ca.SX:
    result = ca.SX(0)
    for condition in conditions:
        result = ca.logic_or(result, condition > 0)
    return result
