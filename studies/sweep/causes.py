"""What failed in a run of a sweep: an index into one list of names, as in a CF flag variable."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...codegen.batch import Outcome
from ...codegen.failure import watched
from ...codegen.loop import Loop
from ...model.block import Block

# the first of all names: what did not fail
NONE = "none"

Causes = NDArray[np.int16]


def causes(loop: Loop, observers: Sequence[str]) -> list[str]:
    """`none`, then each state, output and domain of the truth and the observers, every name once."""
    blocks = [loop.truth, *(block for block in loop.observers if block.name in observers)]
    return list(dict.fromkeys([NONE, *(name for block in blocks for _, name in watched(block))]))


def cause_of(block: Block, outcome: Outcome, names: Sequence[str]) -> Causes:
    """(runs) the index in `names` of what failed in `block`; 0 if nothing did."""
    indices = np.array([names.index(name) for _, name in watched(block)], dtype=np.int16)
    return np.where(outcome.failed < 0, np.int16(0), indices[outcome.cause])


def flags(names: Sequence[str], sentence: str) -> dict[str, object]:
    """The attributes of a variable that holds causes."""
    # CF separates meanings by blanks
    meanings = " ".join(name.replace(" ", "_") for name in names)
    return {
        "long_name": sentence,
        "flag_values": np.arange(len(names), dtype=np.int16),
        "flag_meanings": meanings,
    }
