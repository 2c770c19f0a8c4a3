"""The gain conditions of an observer with what the first pass tells of a recording."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ...model.block import Symbols, symbols
from ...observers import Observer
from ...observers.conditions import FACTS, Checked, check
from ...observers.observer import Sizes


def gain_conditions(observer: Observer, numbers: Mapping[str, float], sizes: Sizes, h: float) -> list[Checked]:
    """What the observer's theorem asks of its `numbers` (name → value); what a recording does not tell is left out.

    The integration needs no check: the steps from sample to sample are chosen by it.
    """
    p, about = symbols(numbers), symbols(FACTS)
    return check(observer.theorem(p, about), Symbols({**p, **about}), {**numbers, **_facts(sizes, h)})


def _facts(sizes: Sizes, h: float) -> dict[str, float]:
    # any p > 0 will do, the smallest asks least; a rate of Δ_Φ or u is not known
    known = {"h": h, "U_m": sizes.U_max, "f_plus": sizes.D_max, "p": 0.0}
    return {**dict.fromkeys(FACTS, math.nan), **known}
