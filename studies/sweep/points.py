"""The numbers of some runs of a sweep, at any values of the parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ...codegen.batch import CompiledLoop, Outcome
from ...codegen.memory import Grid
from ...model.arrays import Array
from ...model.block import Block
from ..files.progress import Progress, unseen
from ..simulate.measures import measures
from .causes import Causes, cause_of, causes
from .plan import Plan, Seeds
from .row import Rows


def compute_part(plan: Plan, compiled: CompiledLoop, part: int, progress: Progress = unseen) -> Rows:
    """(runs) the numbers of one part; what `progress` raises ends it."""
    runs = plan.members(part)
    return _compute(plan, compiled, runs, plan.on_grids(runs), progress)


def compute_at_half_step(plan: Plan, compiled: CompiledLoop, runs: NDArray[np.int64]) -> Rows:
    """(runs) the numbers of some runs, with the same noise, at half the step."""
    grids = ((grid.halved(), which) for grid, which in plan.on_grids(runs))
    return _compute(plan, compiled, runs, grids, unseen)


def _compute(
    plan: Plan,
    compiled: CompiledLoop,
    runs: NDArray[np.int64],
    grids: Iterable[tuple[Grid, NDArray[np.intp]]],
    progress: Progress,
) -> Rows:
    """(runs) the numbers of some runs; grids: each with the places within `runs` that run on it."""
    parameters, seeds = plan.numbers(runs), plan.seeds_of(runs)
    rows = np.empty(len(runs), plan.row)
    for grid, which in grids:
        chosen = {name: numbers[which] for name, numbers in parameters.items()}
        rows[which] = run_points(plan, compiled, grid, seeds[which], chosen, progress)
    return rows


def run_points(
    plan: Plan,
    compiled: CompiledLoop,
    grid: Grid,
    seeds: Seeds,
    parameters: Mapping[str, Array],
    progress: Progress = unseen,
) -> Rows:
    """(runs) what the observers of `plan` score in runs on one time grid, with any numbers.

    seeds: (runs); parameters: Block name → (runs × numbers) in the order of its `p`.
    """
    outcomes = compiled.batch(grid, seeds, parameters, plan.observers, progress)
    loop, names = compiled.loop, causes(compiled.loop, plan.observers)
    blocks = {block.name: block for block in loop.observers}
    rows = np.empty(len(seeds), plan.row)
    for place, observer in enumerate(plan.observers):
        outcome, points = outcomes[observer], grid.of(blocks[observer])
        sums = dict(zip(loop.score.x, outcome.sums.T, strict=True))
        for measure, by_quantity in measures(sums, points, plan.quantities, plan.measures).items():
            rows[measure][:, place] = np.stack([by_quantity[quantity] for quantity in plan.quantities], axis=1)
        rows["failed_at"][:, place], rows["failure"][:, place] = _failures(blocks[observer], outcome, grid, names)
    rows["plant_failed_at"], rows["plant_failure"] = _failures(loop.truth, outcomes[loop.truth.name], grid, names)
    return rows


def _failures(block: Block, outcome: Outcome, grid: Grid, names: Sequence[str]) -> tuple[Array, Causes]:
    """(runs) when `block` failed, NaN if it did not, and the index in `names` of what did."""
    return np.where(outcome.failed < 0, np.nan, outcome.failed * grid.h), cause_of(block, outcome, names)
