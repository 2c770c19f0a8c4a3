"""A Block that nobody tells anything, from step to step, as functions of its state: what every target calls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca

from ...model.block import Block
from ..stepper import functions
from .follower import all_of, any_of

STEPS = "steps"


@dataclass(frozen=True)
class Schedule:
    """The step of RK4, in the Block's unit of time, and the held inputs that are 1 from a step on until another."""

    h: float
    pulses: Mapping[str, tuple[int, int]]


@dataclass(frozen=True, eq=False)  # compared by identity: SX has no usable ==
class FreeRun:
    """The functions of one Block, and the names of its states in order.

    They are those of a Follower, with one step on the way to the next sample, and no numbers in u.
    """

    states: tuple[str, ...]
    functions: Mapping[str, ca.Function]


def free_run(block: Block, schedule: Schedule, prefix: str) -> FreeRun:
    """The run of a Block whose inputs are time and the pulses of a schedule."""
    roles = functions(block, [*schedule.pulses], ())
    x, m, p = (ca.SX.sym(name, size) for name, size in (("x", len(block.x)), ("m", len(block.x)), ("p", len(block.p))))
    u, k, i, d = ca.SX.sym("u", 0), ca.SX.sym("k"), ca.SX.sym("i"), ca.SX.sym("d")
    s, h = ca.vertcat(x, k), schedule.h

    def held(step: ca.SX) -> ca.SX:
        """The pulses during a step."""
        return ca.SX(ca.vertcat(*(ca.logic_and(on <= step, step < off) for on, off in schedule.pulses.values())))

    begun = roles["init"](0, p, held(ca.SX(0)), [])
    moved, _ = roles["step"](k * h, h, m, p, held(k), [])
    # counted, so that time is not a sum of rounded steps
    now = k + d
    y, domain = roles["out"](now * h, m, p, held(now), [])
    guards = roles["watch"](now * h, m, p, held(now), [])
    within = ca.fabs(ca.vertcat(m, y)) * roles["scales"](h, p) <= 1
    fine = all_of(ca.vertsplit(ca.vertcat(within, domain > 0)))
    told, limited = ca.vertcat(y, guards), any_of(ca.vertsplit(guards))
    made = {
        "start": ([p, u], [ca.vertcat(begun, 0)]),
        "depart": ([s], [x]),
        "advance": ([i, p, s, u, m], [moved]),
        "arrive": ([d, p, s, u, m], [ca.vertcat(m, now), told, fine, limited]),
    }
    return FreeRun(
        states=(*block.x, STEPS),
        functions={
            role: ca.Function(f"{prefix}_{role}", inputs, ca.cse([ca.densify(output) for output in outputs]))
            for role, (inputs, outputs) in made.items()
        },
    )
