"""The gain conditions of the observers with the numbers of a run, or of all points of a sweep."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ..codegen.batch import Trace
from ..codegen.library import Array
from ..model.block import Block, Symbols, symbols
from ..observers import OBSERVERS
from ..observers.conditions import FACTS, Checked, Condition, check, violated
from .plan import Plan
from .prepare import Prepared
from .region import where

# so many points are checked at once
_POINTS = 4096


def gain_conditions(prepared: Prepared, truth: Trace) -> dict[str, list[Checked]]:
    """The gain conditions of each registered observer, with suprema from the recorded truth."""
    result, known = {}, facts(prepared, truth)
    for block, conditions, every in _conditions(prepared):
        values = dict(zip(block.p, prepared.table.values(block, prepared.scenario.given), strict=True))
        result[block.name] = check(conditions, every, {**values, **known})
    return result


def swept_conditions(wanted: Plan, truth: Trace) -> dict[str, list[str]]:
    """For each registered observer a sentence for each condition that does not hold at all points.

    The suprema are those of `truth`, the recorded run of the scenario itself.
    """
    known, result = facts(wanted.prepared, truth), {}
    points = np.arange(int(np.prod(wanted.axes.shape)))
    slices = [points[i : i + _POINTS] for i in range(0, len(points), _POINTS)]
    for block, conditions, every in _conditions(wanted.prepared):
        found = [violated(conditions, every, _numbers(wanted, block, some, known)) for some in slices]
        broken = {name: np.concatenate([one[name] for one in found]) for name in found[0]}
        result[block.name] = [
            f"{name} does not hold {where(wanted.axes, at)}" for name, at in broken.items() if at.any()
        ]
    return {name: sentences for name, sentences in result.items() if sentences}


def facts(prepared: Prepared, truth: Trace) -> dict[str, float]:
    """The FACTS of a run."""
    signal = dict(zip(prepared.loop.truth.y, truth.y.T, strict=True))
    spacing = prepared.grid.h * prepared.grid.record

    def supremum(name: str) -> float:
        rates = np.abs(np.diff(signal[name])) / spacing
        return float(np.nanmax(rates)) if np.isfinite(rates).any() else math.nan

    largest = float(np.nanmax(np.abs([signal["u1"], signal["u2"]]), initial=0.0))
    limit = prepared.value("controller.u_max") if prepared.scenario.drive != "given" else 0.0
    return {
        "h": prepared.grid.h,
        "U_m": max(limit, largest),
        **{f"sup_d{name}": supremum(name) for name in ("Delta", "u1", "u2")},
    }


def _conditions(prepared: Prepared) -> Iterator[tuple[Block, list[Condition], Symbols]]:
    """Each registered observer of a run, its conditions, and the symbols in them."""
    for block in prepared.loop.observers:
        if block.name in prepared.observers and block.name in OBSERVERS:
            p, about = symbols(block.p), symbols(FACTS)
            yield block, OBSERVERS[block.name].conditions(p, about), Symbols({**p, **about})


def _numbers(
    wanted: Plan, block: Block, points: np.ndarray[tuple[int], np.dtype[np.int64]], known: dict[str, float]
) -> Array:
    """(symbols × points) the numbers of `block` and the FACTS at some points."""
    runs = points * len(wanted.seeds)
    about = np.tile(list(known.values()), (len(runs), 1))
    for grid, which in wanted.on_grids(runs):
        about[which, list(known).index("h")] = grid.h
    return np.hstack([wanted.numbers(runs)[block.name], about]).T
