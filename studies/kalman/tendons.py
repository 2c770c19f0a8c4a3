"""The tendons of a recording, linear about what a filter makes of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...model.system import pair_system
from ...observers.kalman.inputs import INPUTS_MODEL
from ...observers.ports import ESTIMATES
from ...observers.slopes import SLOPES
from ...observers.tendons import LENGTHS
from .muscles import TENDONS, compiled_muscles
from .orders import before_a_fit
from .passes import compiled
from .record import Record
from .run import How, over


def about_estimates(record: Record) -> Record:
    """The record with lengths and slopes of tendons that are linear about causal estimates, not about measured forces.

    The densities of that filter are those that the sizes of the recording let expect.
    """
    told = over(compiled(INPUTS_MODEL), before_a_fit(record, {}), record.table(), How(lag=0), 0)
    estimates = dict(zip(ESTIMATES, np.concatenate([rows[:, : len(ESTIMATES)].copy() for rows in told]).T, strict=True))
    forces = {"y2": record.y[:, 1], "y3": record.y[:, 2]}
    lines = compiled_muscles(pair_system(record.curves)).outputs(TENDONS, record.numbers, {**estimates, **forces})
    z, slopes = (np.stack([lines[name] for name in names], axis=1) for names in (LENGTHS, SLOPES))
    return replace(record, z=z, slopes=slopes)
