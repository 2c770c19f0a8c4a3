"""The leanest equations that our graph gives, for the peers: numbers folded in, shared terms once, time as a table.

Both forms find the tendons' lengths by the seed and the series of `CurveSet.Phi_S_inv_near`, without its guard, once
for all observers. `lean_rates` is ẋ, for a peer's own RK4; `lean_step` is a whole RK4 step with one seed for its four
stages, which is what our kernel runs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from hillobs.codegen.constants import hoisted
from hillobs.codegen.stepper import STAGES
from hillobs.model.arrays import Array
from hillobs.model.block import Block, BlockError, Symbols
from hillobs.observers.tendons import tendons_of_a_step

from .problem import Problem, right_hand_side


@dataclass(frozen=True)
class Lean:
    """`function`: c (what follows from time alone), x, w → ẋ or x after a step; `clock`: t → c."""

    function: ca.Function
    clock: ca.Function

    def table(self, times: Array) -> Array:
        """(times × numbers) of c."""
        return np.array(np.array(self.clock(times[None, :])).T, dtype=np.float64, order="C")


def lean_rates(of: Problem) -> Lean:
    """ẋ = f(c, x, w)."""
    bank = replace(of.loop.bank, front=_front_of_a_stage(of), near=None)
    quick = replace(of, loop=replace(of.loop, bank=bank))
    f, numbers = right_hand_side(quick)
    rates = _folded("rates", f.name(), {"init": f, "rates": f}, of.grid.h, numbers)
    t, x, w = ca.SX.sym("t"), ca.SX.sym("x", len(of.x0)), ca.SX.sym("w", len(of.loop.noise))
    return _lean("lean_rates", rates(t=t, x=x, w=w)["dx"], t, x, w)


def lean_step(of: Problem) -> Lean:
    """x⁺ = step(c, x, w): the truth first, then what the sensors see, the tendons, each observer."""
    loop = of.loop
    t, x, w = ca.SX.sym("t"), ca.SX.sym("x", len(of.x0)), ca.SX.sym("w", len(loop.noise))
    held = ca.vertcat(w, ca.SX.zeros(len(loop.held) - len(loop.noise)))
    sizes = [len(block.x) for block in (loop.truth, *of.observers)]
    states = ca.vertsplit(x, np.cumsum([0, *sizes]).tolist())

    def role(name: str, block: Block, numbers: Sequence[float]) -> ca.Function:
        return _folded(name, block.name, loop.functions(block), of.grid.h, numbers)

    truth = role("step", loop.truth, of.numbers[loop.truth.name])(t=t, x=states[0], held=held)
    look = role("out", loop.sensors, of.numbers[loop.sensors.name])
    measured = [look(held=held, staged=stage)["y"] for stage in ca.horzsplit(truth["stages"])]
    near = _there(loop.bank.near)
    blank = ca.SX.zeros(len(loop.bank.front.y))
    # the front sees a column of the measurements, and room for its own results, per stage
    given = ca.vertcat(*(entry for y in measured for entry in (y, blank)))
    lengths = role("out", near, of.front(near))(staged=given)["y"][:-1]
    staged = ca.vertcat(ca.horzcat(*measured), ca.reshape(lengths, -1, STAGES))
    after = [truth["x_next"]]
    for block, state in zip(of.observers, states[1:], strict=True):
        step = role("step", block, of.numbers[block.name])
        after.append(step(t=t, x=state, held=held, staged=staged)["x_next"])
    return _lean("lean_step", ca.vertcat(*after), t, x, w)


def _front_of_a_stage(of: Problem) -> Block:
    """The front by the quick inverse, at one stage."""
    near = _there(tendons_of_a_step(1))
    u = Symbols({name.removesuffix(".0"): symbol for name, symbol in near.u.items()})
    y = Symbols({name.removesuffix(".0"): length for name, length in near.y.items() if name != "doubt"})
    return replace(near, name=of.loop.bank.front.name, u=u, y=y)


def _there(near: Block | None) -> Block:
    if near is None:
        raise BlockError("the curves have no quick inverse for the peers")
    return near


def _folded(role: str, name: str, table: Mapping[str, ca.Function], h: float, numbers: Sequence[float]) -> ca.Function:
    """A role of a block with its numbers in it, by the same rewriting as for the kernel."""
    roles = hoisted(name, table)
    f, constants = roles[role], roles["constants"](h, numbers)
    inputs = {n: ca.SX.sym(n, *f.size_in(n)) for n in f.name_in() if n != "c"}
    outputs = f.call({**inputs, "c": constants})
    return ca.Function(f.name(), [*inputs.values()], [outputs[n] for n in f.name_out()], [*inputs], f.name_out())


def _lean(name: str, result: ca.SX, t: ca.SX, x: ca.SX, w: ca.SX) -> Lean:
    (reduced,), symbols, values = ca.extract_parametric([ca.cse(result)], t, {"extract_trivial": True})
    c = ca.SX.sym("c", len(symbols))
    reduced = ca.cse(ca.substitute(reduced, ca.vertcat(*symbols), c))
    return Lean(
        ca.Function(name, [c, x, w], [ca.densify(reduced)], ["c", "x", "w"], ["result"]),
        ca.Function("clock", [t], [ca.cse(ca.densify(ca.vertcat(*values)))], ["t"], ["c"]),
    )
