"""The gain conditions of an observer with what the first pass tells of a recording."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ...model.block import Symbols, symbols
from ...model.system import System
from ...observers import Observer
from ...observers.conditions import FACTS, Checked, check
from ...observers.observer import Sizes, SystemSizes


def gain_conditions(
    observer: Observer, system: System, numbers: Mapping[str, float], sizes: SystemSizes, h: float
) -> list[Checked]:
    """What the observer's theorem asks of its `numbers` (name → value); what a recording does not tell is left out.

    The integration needs no check: the steps from sample to sample are chosen by it.
    """
    p, about = symbols(numbers), symbols(FACTS)
    checked: list[Checked] = []
    for of, conditions in observer.theorems(system, p, about).items():
        near = sizes.pair if system.paper else sizes.near(of)
        checked += check(conditions, Symbols({**p, **about}), {**numbers, **_facts(near, h)})
    return checked


def _facts(sizes: Sizes, h: float) -> dict[str, float]:
    # any p > 0 will do, the smallest asks least; a rate of Δ_Φ or u is not known
    known = {"h": h, "U_m": sizes.U_max, "f_plus": sizes.D_max, "p": 0.0}
    return {**dict.fromkeys(FACTS, math.nan), **known}
