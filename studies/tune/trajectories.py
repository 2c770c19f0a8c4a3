"""Other trajectories of a scenario: its sines, with other amplitudes and frequencies.

Gains that were tuned on one trajectory know it: how fast it is, and how strong the uncertainty.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...model.arrays import Array
from ..scenarios.prepare import Prepared

# an amplitude or frequency is at most so many times larger or smaller
_MOST = 1.5
_OF_A_SINE = ("amplitude", "frequency")


@dataclass(frozen=True)
class Trajectories:
    """(trajectories × paths) what the numbers of the sines are."""

    paths: tuple[str, ...]
    values: Array

    def changes(self, place: int) -> dict[str, float]:
        """Path → value of one of them."""
        return dict(zip(self.paths, self.values[place].tolist(), strict=True))


def trajectories(prepared: Prepared, count: int, dice: int) -> Trajectories:
    """The scenario's own, then so many drawn about it; those of other dice are others."""
    pulses = prepared.scenario.world.pulses
    paths = [
        path
        for path in prepared.loop.truth.p
        if path.rpartition(".")[2] in _OF_A_SINE and path.partition(".")[0] not in pulses and prepared.value(path)
    ]
    own = np.array([[prepared.value(path) for path in paths]])
    shares = np.random.default_rng(dice).uniform(-1, 1, (count, len(paths)))
    return Trajectories(tuple(paths), np.vstack([own, own * np.exp(shares * math.log(_MOST))]))
