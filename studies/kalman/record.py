"""A recording as the Kalman filter's passes take it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...model.arrays import Array
from ...model.curves import Curves
from ...model.skeleton.load import pull
from ...observers.kalman.inputs import INPUTS_MODEL
from ...observers.observer import Sizes
from ..files.errors import RecordingError
from .passes import table

# in τ, from its start on, a filter settles: what it innovates there tells nothing of densities
SETTLED = 1.5
# statistics of fewer samples are none
FEW = 50
# of a long recording: number of blocks that densities are fitted to, and samples of each
_BLOCKS, _BLOCK = 10, 10_000


@dataclass(frozen=True, eq=False)
class Record:
    """Times τ (n), measurements y (n × 3), tendon lengths z and slopes (n × 2), where something was seen (n).

    numbers: values of the estimator's parameters by name; T: sampling period in τ; sizes: what the first pass found;
    settling: τ in which the filter settles.
    """

    tau: Array
    y: Array
    z: Array
    slopes: Array
    seen: NDArray[np.bool_]
    numbers: Mapping[str, float]
    sizes: Sizes
    T: float
    curves: Curves
    settling: float = SETTLED

    def __len__(self) -> int:
        return len(self.tau)

    @property
    def columns(self) -> dict[str, Array]:
        """What is known at each sample, by name."""
        # a slack tendon tells no length: its noise is not that of the force
        counted = self.seen & (self.y[:, 1:] > 0).all(axis=1)
        return {
            "t": self.tau,
            "y1": self.y[:, 0],
            "acc": pull(self.y[:, 1:].T) / self.numbers["m"],
            "L_S1": self.z[:, 0],
            "L_S2": self.z[:, 1],
            "slope1": self.slopes[:, 0],
            "slope2": self.slopes[:, 1],
            "seen": self.seen.astype(float),
            "counted": counted.astype(float),
        }

    def table(self) -> Array:
        """The rows of the first pass."""
        return table(INPUTS_MODEL, self.columns)


def segments(length: int) -> Iterator[slice]:
    """The parts of a recording that densities are fitted to: all of it, or ten blocks."""
    if length <= _BLOCKS * _BLOCK:
        yield slice(0, length)
        return
    for start in np.linspace(0, length - _BLOCK, _BLOCKS).astype(int):
        yield slice(int(start), int(start) + _BLOCK)


def settled(rows: Array, settling: float = SETTLED) -> Array:
    """The rows of a segment, of which those at its start do not count, unless hardly any would be left."""
    late = rows[:, 0] >= rows[0, 0] + settling
    if rows[late, -1].sum() < FEW:
        return rows
    rows = rows.copy()
    rows[:, -1] *= late
    return rows


def refuse_short(source: str, length: int) -> None:
    """RecordingError for a recording that no statistics can be made of."""
    if length < FEW:
        raise RecordingError(
            f"{source}: has {length} rows of numbers; a Kalman filter finds its densities in {FEW} or more"
        )
