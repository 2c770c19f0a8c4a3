"""A case that breaks a promise, with less in it: layers are left out as long as the same sentence remains."""

from __future__ import annotations

import re
from collections.abc import Sequence

from hostile.case import Layer, without
from hostile.warm import Warm


def shrunk(warm: Warm, layers: Sequence[Layer], wrong: Sequence[str]) -> list[Layer]:
    """The layers that are needed for the first of the sentences."""
    needed, i = list(layers), 0
    while i < len(needed):
        fewer = without(needed, i)
        warm.ask(layers=fewer)
        if kind(wrong[0]) in map(kind, warm.answer()["verdict"]["wrong"]):
            needed = fewer
        else:
            i += 1
    return needed


def kind(sentence: str) -> str:
    """What a sentence says without its numbers and names: equal kinds are likely one mistake."""
    return re.sub(r"^'[^']*'|/\S+|[\d.]+(e[+-]?\d+)?", "…", sentence)
