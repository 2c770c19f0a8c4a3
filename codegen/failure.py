"""Why and when a Block has no more numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..model.arrays import Array
from ..model.block import Block


@dataclass(frozen=True)
class Failure:
    """`name` is a state or an output that is not a number within ±`limit` at `time`, or a domain that is left."""

    time: float
    group: str  # "x", "y" or "domain"
    name: str
    limit: float  # NaN of a domain


def watched(block: Block) -> list[tuple[str, str]]:
    """Group and name of all that is watched, in the order in which a cause is counted."""
    return [(group, name) for group in ("x", "y", "domain") for name in getattr(block, group)]


def failure(block: Block, time: float, cause: int, scales: Array) -> Failure:
    """The failure with a `cause` as the kernel counts it; scales: 1 over the limit of each state, then output."""
    group, name = watched(block)[cause]
    return Failure(time, group, name, math.nan if group == "domain" else float(1 / scales[cause]))
