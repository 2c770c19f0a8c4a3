"""The run of a mechanism as a recording in SI, as `estimate` reads it: what was measured, and the truth beside it."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import xarray as xr

from ...model.arrays import Array
from ..files.tables import Series
from ..laboratory.subject import Subject, subject_again
from .schema import FILE

_MEASURED = "_measured"
# where velocities and forces are per time and of length
_UNITS = {"position": ("m", "rad"), "velocity": ("m/s", "rad/s"), "disturbance": ("N", "N m")}


def recording_columns(dataset: xr.Dataset) -> Iterator[Series]:
    """The columns of the recording: time, positions and forces with noise and without, and all that is estimated."""
    subject = subject_again(json.loads(str(dataset[FILE].values)))
    system, s = subject.system, subject.scales
    joints = len(system.joints)
    yield Series("time", "s", dataset.time.values / s.rate)
    y = dataset.y.values
    yield from _of_joints(subject, "position", s.positions(y[:, :joints]), _MEASURED)
    yield from _of_muscles(subject, "force", "N", y[:, joints:] * s.force, _MEASURED)
    q, dq, L_S = (_states(dataset, names) for names in (system.joint("q"), system.joint("dq"), system.muscle("L_S")))
    L_m, u = subject.laws.lengths(q), dataset.u.values
    along = s.metres(L_m - L_S)
    fibres = np.hypot(along, subject.heights)
    yield from _of_joints(subject, "position", s.positions(q))
    yield from _of_joints(subject, "velocity", s.velocities(dq))
    yield from _of_joints(subject, "disturbance", subject.disturbance(q, dataset.Delta.values))
    yield from _of_muscles(subject, "force", "N", dataset.Phi_S.values * s.force)
    yield from _of_muscles(subject, "path_length", "m", s.metres(L_m))
    yield from _of_muscles(subject, "tendon_length", "m", s.metres(L_S))
    yield from _of_muscles(subject, "fibre_length", "m", fibres)
    yield from _of_muscles(subject, "fibre_velocity", "m/s", s.fibre_velocity(u) * along / fibres)
    yield from _of_muscles(subject, "activation", "1", dataset.a.values)


def _states(dataset: xr.Dataset, names: tuple[str, ...]) -> Array:
    return np.asarray(dataset.x.sel(state=list(names)).values)


def _of_joints(subject: Subject, quantity: str, values: Array, suffix: str = "") -> Iterator[Series]:
    for column, sliding, of in zip(subject.names[quantity], subject.scales.sliding, values.T, strict=True):
        yield Series(column + suffix, _UNITS[quantity][0 if sliding else 1], of)


def _of_muscles(subject: Subject, quantity: str, unit: str, values: Array, suffix: str = "") -> Iterator[Series]:
    for column, of in zip(subject.names[quantity], values.T, strict=True):
        yield Series(column + suffix, unit, of)
