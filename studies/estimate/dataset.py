"""What observers made of a recording, in SI and with names."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...codegen.failure import Failure
from ...model.arrays import Array
from ...model.curves import CURVES
from ...model.symbols import hat
from ...observers.conditions import Checked
from ..files.datasets.schema import read_json
from ..files.versions import versions
from ..laboratory.quantities import OR, UNITS_OF_MUSCLES, quantities_of, unit_of_joints
from ..laboratory.subject import subject_again
from ..simulate.failures import observer_failure
from .bands.band import deviations
from .case import Case, Result

# what a recording may know: name → sentence, and the unit if it is none of the joint
TRUE: Mapping[str, tuple[str, str]] = {
    "position": ("", "true positions"),
    "velocity": ("", "true velocities"),
    "acceleration": ("", "true accelerations"),
    "disturbance": ("", "true external forces, positive with the position"),
    "force": (UNITS_OF_MUSCLES["force"], "true tendon forces"),
    "path_length": (UNITS_OF_MUSCLES["path_length"], "true muscle lengths"),
    "tendon_length": (UNITS_OF_MUSCLES["tendon_length"], "true tendon lengths"),
    "fibre_length": (UNITS_OF_MUSCLES["fibre_length"], "true fibre lengths"),
    "fibre_velocity": (UNITS_OF_MUSCLES["fibre_velocity"], "true fibre velocities, positive when the fibre lengthens"),
    "activation": (UNITS_OF_MUSCLES["activation"], "true activations"),
    "excitation": (UNITS_OF_MUSCLES["excitation"], "true excitations"),
}
PER_JOINT = ("position", "velocity", "acceleration", "disturbance")
PER_MUSCLE = tuple(name for name in TRUE if name not in PER_JOINT)
# unit of the Dataset → that on paper, and how many of these it is
ON_PAPER: Mapping[str, tuple[str, float]] = {"m": ("mm", 1e3), "m/s": ("mm/s", 1e3)}
# noise about the end of a joint's range, as a part of it
_AT_THE_END = 0.01
Variable = tuple[tuple[str, ...], np.ndarray[Any, Any], dict[str, str]]


def estimate_dataset(case: Case, results: Mapping[str, Result], library: str) -> xr.Dataset:
    """Estimates, innovations and limits of each observer, what was measured, and the truth that the file knows.

    A pair's one position needs no dimension for joints.
    """
    recording, s, subject = case.recording, case.scales, case.subject
    system, joints = subject.system, len(subject.system.joints)
    y, z = case.y[case.kept], case.z[case.kept]
    of_observers = ("observer", "time")

    def stacked(names: Sequence[str]) -> Array:
        """(observer × time × joint or muscle) of outputs."""
        return np.stack([np.stack([r.y[hat(name)] for name in names], axis=-1) for r in results.values()])

    def limited(signal: str) -> Variable:
        # an observer that estimates activations itself has no such limit
        none = np.zeros(len(y))
        names = [f"{hat(name)}_limit" for name in system.muscle(signal)]
        guards = [[r.guards.get(name, none) for name in names] for r in results.values()]
        # after a failure nothing is limited
        active: Array = np.nan_to_num(np.array(guards, dtype=float))
        return of_muscle(of_observers, active.transpose(0, 2, 1).astype(np.int8), "1", _LIMITED[signal])

    def of_joint(dims: tuple[str, ...], values: Array, quantity: str, sentence: str) -> Variable:
        about = _about(unit_of_joints(s.sliding, quantity), sentence)
        return ((*dims, "joint"), values, about) if subject.joints else (dims, values[..., 0], about)

    def of_muscle(dims: tuple[str, ...], values: np.ndarray[Any, Any], unit: str, sentence: str) -> Variable:
        return (*dims, "muscle"), values, _about(unit, sentence)

    q, L_S, told = stacked(system.joint("q")), stacked(system.muscle("L_S")), stacked(system.quantities)
    of = quantities_of(subject)(told)
    data: dict[str, Variable] = {
        "position": of_joint(("time",), s.positions(y[:, :joints]), "position", "measured positions"),
        "force": of_muscle(("time",), y[:, joints:] * s.force, "N", "measured tendon forces"),
        "position_hat": of_joint(of_observers, of["position"], "position", "estimated positions"),
        "velocity_hat": of_joint(of_observers, of["velocity"], "velocity", "estimated velocities"),
        "disturbance_hat": of_joint(of_observers, of["disturbance"], "disturbance", "estimated external forces"),
        "tendon_length_hat": of_muscle(of_observers, of["tendon_length"], "m", "estimated tendon lengths"),
        "fibre_length_hat": of_muscle(of_observers, of["fibre_length"], "m", "estimated fibre lengths"),
        "fibre_velocity_hat": of_muscle(
            of_observers,
            of["fibre_velocity"],
            "m/s",
            "estimated fibre velocities, positive when the fibre lengthens",
        ),
        "activation_hat": of_muscle(of_observers, of["activation"], "1", "estimated activations, within [0, 1]"),
        "position_innovation": of_joint(
            of_observers, s.positions(y[:, :joints] - q), "position", "measured less estimated positions"
        ),
        "tendon_innovation": of_muscle(
            of_observers, s.metres(z - L_S), "m", "tendon length of the measured force less the estimated one"
        ),
        "velocity_limited": limited("u"),
        "activation_limited": limited("a"),
        "slack": of_muscle(
            ("time",),
            (y[:, joints:] <= 0).astype(np.int8),
            "1",
            "1 where no force is measured: the tendon length is not determined",
        ),
        "bridged": (
            ("time",),
            case.gaps[case.kept].astype(np.int8),
            _about("1", "1 where a gap of the recording was bridged"),
        ),
        # no attribute: the tables of a user's curves are longer than these may be
        "muscle_file": (
            (),
            np.array(json.dumps(subject.file)),
            {"long_name": "the muscles in SI, and what they pull, as JSON"},
        ),
    }
    data |= deviations(case, results, {name: unit_of_joints(s.sliding, name) for name in PER_JOINT})
    for name, (unit, sentence) in TRUE.items():
        columns = subject.names.get(name, ())
        if columns and all(column in recording.true for column in columns):
            values = np.stack([recording.true[column][case.kept] for column in columns], axis=-1)
            known = of_joint(("time",), values, name, sentence) if name in PER_JOINT else None
            data[f"true_{name}"] = known or of_muscle(("time",), values, unit, sentence)
    coordinates: dict[str, Any] = {
        "time": ("time", recording.time[case.kept], {"long_name": "time", "units": "s"}),
        "observer": list(results),
        "muscle": list(subject.labels),
        **({"joint": list(subject.joints)} if subject.joints else {}),
    }
    return xr.Dataset(data, coordinates, _manifest(case, results, library))


_LIMITED = {
    "u": "1 where a fibre is faster than the activation allows",
    "a": "1 where the activation would be below 0 or above 1",
}


def joint_units(dataset: xr.Dataset, variable: str) -> dict[str, str]:
    """The unit of each joint's part of a variable, by joint: that of all, unless some slide and some turn."""
    slides, _, turns = str(dataset[variable].attrs["units"]).partition(OR)
    names = dataset.joint.values.tolist()
    if not turns:
        return dict.fromkeys(names, slides)
    subject = subject_again(read_json("muscle_file", str(dataset.muscle_file.values), dict))
    sliding = dict(zip(subject.joints, subject.scales.sliding, strict=True))
    return {name: slides if sliding[name] else turns for name in names}


def _about(unit: str, sentence: str) -> dict[str, str]:
    return {"long_name": sentence, "units": unit}


def _beyond_ranges(case: Case) -> Iterator[str]:
    """Joints that leave the range in which the paths hold; noise about its ends is no leaving."""
    for column, bound in case.subject.positions.items():
        if bound.range is None:
            continue
        least, most = bound.range
        position = case.recording[column]
        farthest = np.maximum(least - position, position - most)
        outside = int(np.sum(farthest > _AT_THE_END * (most - least)))
        if outside:
            yield (
                f"{column} is beyond {least:g} to {most:g} {bound.unit} in {outside:,} of {len(position):,} rows, "
                f"by at most {np.nanmax(farthest):.3g}: the paths of the muscles go on there as polynomials, unchecked"
            )


def _manifest(case: Case, results: Mapping[str, Result], library: str) -> dict[str, str]:
    """How the estimates were made; everything as text, for NetCDF."""
    recording = case.recording
    curves = [muscle.curves for muscle in case.subject.muscles.values()]
    # how closely a user's tables are followed
    tables = {f"{curve_set.name}: {curve_set.sentence}": None for curve_set in curves if curve_set.name not in CURVES}
    return {
        "Conventions": "CF-1.11",
        "title": f"hillobs: estimates from {recording.source}",
        "source": recording.source,
        "notes": json.dumps([*recording.notes(), *_beyond_ranges(case), *tables]),
        "settings": json.dumps({"mapping": dict(recording.mapping), **dataclasses.asdict(case.settings)}),
        "numbers": json.dumps(dict(case.scales.numbers)),
        "curves": json.dumps([curve_set.name for curve_set in curves]),
        "sizes": json.dumps(dataclasses.asdict(case.sizes)),
        "doubt": json.dumps(dict(case.doubt)),
        "gains": json.dumps({name: dict(result.gains) for name, result in results.items()}),
        "substeps": json.dumps({name: result.substeps for name, result in results.items()}),
        "fits": json.dumps({name: result.fit for name, result in results.items() if result.fit}),
        "violated_conditions": json.dumps({n: [str(c) for c in r.violated] for n, r in results.items() if r.violated}),
        "failures": json.dumps({n: _explain(case, n, r.failure, r.violated) for n, r in results.items() if r.failure}),
        "period": repr(case.period / case.scales.rate),
        "longest_step": repr(float(np.diff(recording.time).max())),
        "duration": repr(float(recording.time[-1] - recording.time[0])),
        "samples": str(len(case.tau)),
        "library": library,
        "versions": json.dumps(versions()),
    }


def _explain(case: Case, name: str, failure: Failure, violated: Sequence[Checked]) -> str:
    return explained(name, failure, case.recording.time[0] + failure.time / case.scales.rate, violated)


def explained(name: str, failure: Failure, time: float, violated: Sequence[Checked] = ()) -> str:
    """Why an observer has no estimates from a time on, in s; violated: its gain conditions that do not hold."""
    likely = "the gains are too fast or unstable, or the data too wild"
    return observer_failure(name, failure, f"at {time:.4g} s", [condition.name for condition in violated], likely)
