"""What candidates, sets of gains, are worth: which conditions they break, and what the observer then misses."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...codegen.batch import CompiledLoop, Trace
from ...model.arrays import Array
from ..sweep.axes import Axes
from ..sweep.computing import Compute
from ..sweep.conditions import Violated, swept_conditions
from ..sweep.plan import Plan, Seeds
from .equations import Equation
from .trajectories import Trajectories

# digits of a number that is tried: a file of gains is read by people
_DIGITS = 4


@dataclass(frozen=True)
class Candidates:
    """How sets of gains of one observer are tried. paths: of what is tuned, in the order of a candidate's numbers.

    equations: of the numbers that follow from these. truths: recorded runs, for the suprema that conditions are about.
    """

    plan: Plan
    compiled: CompiledLoop
    paths: tuple[str, ...]
    equations: Sequence[Equation]
    truths: Sequence[Trace]
    compute: Compute

    def broken(self, numbers: Array) -> Array:
        """(candidates) how many gain conditions each does not fulfil, counted for each recorded truth."""
        each = [at for violated in self.violated(numbers) for of in violated.values() for at in of.values()]
        return np.sum(each, axis=0, dtype=float) if each else np.zeros(len(numbers))

    def violated(self, numbers: Array) -> list[Violated]:
        """The gain conditions that some candidates do not fulfil, for each recorded truth."""
        plan = replace(self.plan, axes=self.axes(numbers))
        return [swept_conditions(plan, truth) for truth in self.truths]

    def errors(self, numbers: Array, trajectories: Trajectories, seeds: Seeds) -> Array:
        """(candidates × trajectories × seeds × quantities) RMSE; NaN in a run that fails."""
        count, others = len(numbers), len(trajectories.values)
        gains, signals = self.axes(np.repeat(numbers, others, axis=0)), np.tile(trajectories.values, (count, 1))
        axes = Axes("zip", (*gains.paths, *trajectories.paths), (*gains.values, *signals.T))
        plan = replace(self.plan, axes=axes, seeds=seeds)
        rows = np.empty(plan.runs, plan.row)
        # its threads end with it, however it ends
        with contextlib.closing(self.compute(plan, self.compiled, range(plan.parts))) as computed:
            for part, fresh in computed:
                rows[plan.members(part)] = fresh
        rmse: Array = rows["rmse"][:, 0].reshape(count, others, len(seeds), -1)
        return rmse

    def axes(self, numbers: Array) -> Axes:
        """The candidates as the points of a sweep, with the numbers that follow from theirs."""
        values = dict(zip(self.paths, rounded(numbers).T, strict=True))
        prepared = self.plan.prepared
        values |= {one.path: one.solved(prepared, values, len(numbers)) for one in self.equations}
        return Axes("zip", tuple(values), tuple(values.values()))


def rounded(numbers: Array) -> Array:
    """The numbers with the digits that are tried."""
    each = [float(f"{number:.{_DIGITS}g}") for number in numbers.ravel().tolist()]
    return np.array(each).reshape(numbers.shape)
