"""The gain conditions of the observers with the numbers of a run."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...codegen.batch import Trace
from ...model.block import Block, Symbols, symbols
from ...observers import OBSERVERS
from ...observers.conditions import FACTS, Checked, Condition, check
from ..scenarios.prepare import Prepared

# the paper's choice of gains is for |Δ_Φ| < f⁺, and takes this p of [lambda11]
_F_PLUS, _P = 1.0, 0.5


def gain_conditions(prepared: Prepared, truth: Trace) -> dict[str, list[Checked]]:
    """The gain conditions of each registered observer, with suprema from the recorded truth."""
    result, of_run = {}, facts(prepared, truth)
    for block, conditions, known in conditions_of(prepared):
        values = dict(zip(block.p, prepared.paths.values(block, prepared.scenario.given), strict=True))
        result[block.name] = check(conditions, known, {**values, **of_run})
    return result


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
        "f_plus": _F_PLUS,
        "p": _P,
        **{f"sup_d{name}": supremum(name) for name in ("Delta", "u1", "u2")},
    }


def conditions_of(prepared: Prepared) -> Iterator[tuple[Block, list[Condition], Symbols]]:
    """Each registered observer of a run, its conditions, and the symbols in them."""
    for block in prepared.loop.observers:
        if block.name in prepared.observers and block.name in OBSERVERS:
            p, about = symbols(block.p), symbols(FACTS)
            yield block, OBSERVERS[block.name].conditions(p, about), Symbols({**p, **about})
