"""The gain conditions of the observers with the numbers of a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

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
    spacing, system = prepared.grid.h * prepared.grid.record, prepared.system

    def supremum(names: Sequence[str]) -> float:
        rates = np.abs(np.diff([signal[name] for name in names])) / spacing
        return float(np.nanmax(rates)) if np.isfinite(rates).any() else math.nan

    inputs = system.muscle("u")
    largest = float(np.nanmax(np.abs([signal[name] for name in inputs]), initial=0.0))
    # that of a mechanism's muscles is part of their speed, and in what they did
    controlled = system.paper and prepared.scenario.drive != "given"
    limit = prepared.value("controller.u_max") if controlled else 0.0
    # of the pair each muscle's own, else the largest of all
    rates = {f"sup_du{j}": supremum(inputs[j - 1 : j] if system.paper else inputs) for j in (1, 2)}
    return {
        "h": prepared.grid.h,
        "U_m": max(limit, largest),
        "f_plus": _F_PLUS,
        "p": _P,
        "sup_dDelta": supremum(system.joint("Delta")),
        **rates,
    }


def conditions_of(prepared: Prepared) -> Iterator[tuple[Block, list[Condition], Symbols]]:
    """Each registered observer of a run, its conditions, and the symbols in them."""
    for block in prepared.loop.observers:
        if block.name in prepared.observers and block.name in OBSERVERS:
            p, about = symbols(block.p), symbols(FACTS)
            yield block, OBSERVERS[block.name].conditions(prepared.system, p, about), Symbols({**p, **about})
