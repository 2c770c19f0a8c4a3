"""The run of a mechanism as a recording in SI, as `estimate` reads it: what was measured, and the truth beside it."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import xarray as xr

from ...model.arrays import Array
from ..files.tables import Series
from ..laboratory.quantities import UNITS_OF_MUSCLES, quantities_of, unit_of_joints
from ..laboratory.subject import Subject, subject_again
from .schema import FILE

_MEASURED = "_measured"


def recording_columns(dataset: xr.Dataset) -> Iterator[Series]:
    """The columns of the recording: time, positions and forces with noise and without, and all that is estimated."""
    subject = subject_again(json.loads(str(dataset[FILE].values)))
    s, joints = subject.scales, len(subject.joints)
    # in the order of the system's quantities
    told = quantities_of(subject)(np.concatenate([dataset[name].values for name in ("x", "Delta", "u", "a")], axis=1))
    q = dataset.x.sel(state=list(subject.system.joint("q"))).values
    true = {**told, "force": dataset.Phi_S.values * s.force, "path_length": s.metres(subject.laws.lengths(q))}
    y = dataset.y.values
    yield Series("time", "s", dataset.time.values / s.rate)
    yield from _columns(subject, "position", s.positions(y[:, :joints]), _MEASURED)
    yield from _columns(subject, "force", y[:, joints:] * s.force, _MEASURED)
    for quantity, values in true.items():
        yield from _columns(subject, quantity, values)


def _columns(subject: Subject, quantity: str, values: Array, suffix: str = "") -> Iterator[Series]:
    """A column for each joint or muscle (n × joints or muscles)."""
    for i, (column, of) in enumerate(zip(subject.names[quantity], values.T, strict=True)):
        unit = UNITS_OF_MUSCLES.get(quantity) or unit_of_joints(subject.scales.sliding[i : i + 1], quantity)
        yield Series(column + suffix, unit, of)
