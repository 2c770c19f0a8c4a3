"""What observers made of a recording, in SI and with names."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...codegen.failure import Failure
from ...model.arrays import Array
from ...model.curves import CURVES
from ...model.skeleton.load import lengths
from ...model.symbols import STATES, hat
from ...observers.conditions import Checked
from ..files.versions import versions
from ..laboratory.muscles import muscle_file
from ..simulate.failures import observer_failure
from .bands.band import deviations
from .case import Case, Result

_MUSCLES = (1, 2)
# what a recording may know: name, unit, sentence
TRUE: Mapping[str, tuple[str, str]] = {
    "position": ("m", "true position of the mass"),
    "velocity": ("m/s", "true velocity of the mass"),
    "acceleration": ("m/s2", "true acceleration of the mass"),
    "disturbance": ("N", "true external force on the mass, positive to the right"),
    "force": ("N", "true tendon forces"),
    "tendon_length": ("m", "true tendon lengths"),
    "fibre_length": ("m", "true fibre lengths"),
    "fibre_velocity": ("m/s", "true fibre velocities, positive when the fibre lengthens"),
    "activation": ("1", "true activations"),
    "excitation": ("1", "true excitations"),
}
PER_MUSCLE = ("force", "tendon_length", "fibre_length", "fibre_velocity", "activation", "excitation")


def estimate_dataset(case: Case, results: Mapping[str, Result], library: str) -> xr.Dataset:
    """Estimates, innovations and limits of each observer, what was measured, and the truth that the file knows."""
    recording, s = case.recording, case.scales
    y, z = case.y[case.kept], case.z[case.kept]
    alone, both = ("observer", "time"), ("observer", "time", "muscle")

    def stacked(*names: str) -> Array:
        """(observer × time) of one output, (observer × time × muscle) of two."""
        outputs = [np.stack([result.y[hat(name)] for name in names], axis=-1) for result in results.values()]
        return np.stack(outputs)[..., 0] if len(names) == 1 else np.stack(outputs)

    def limited(quantity: str) -> NDArray[np.int8]:
        # an observer that estimates activations itself has no such limit
        none = np.zeros(len(y))
        guards = [[r.guards.get(f"{quantity}{j}_hat_limit", none) for j in _MUSCLES] for r in results.values()]
        # after a failure nothing is limited
        active: Array = np.nan_to_num(np.array(guards, dtype=float))
        return active.transpose(0, 2, 1).astype(np.int8)

    x1, L_S = stacked("x1"), stacked(*STATES[2:])
    # L_C = L_m − L_S
    L_m = np.stack(lengths(x1, s.numbers["plant.C"]), axis=-1)
    data: dict[str, tuple[tuple[str, ...], np.ndarray[Any, Any], dict[str, str]]] = {
        "position": (("time",), s.metres(y[:, 0]), _about("m", "measured position")),
        "force": (("time", "muscle"), y[:, 1:] * s.force, _about("N", "measured tendon forces")),
        "position_hat": (alone, s.metres(x1), _about("m", "estimated position")),
        "velocity_hat": (alone, s.velocity(stacked("x2")), _about("m/s", "estimated velocity")),
        "disturbance_hat": (
            alone,
            case.subject.disturbance(x1[..., None], stacked("Delta")[..., None])[..., 0],
            _about("N", "estimated external force"),
        ),
        "tendon_length_hat": (both, s.metres(L_S), _about("m", "estimated tendon lengths")),
        "fibre_length_hat": (both, s.metres(L_m - L_S), _about("m", "estimated fibre lengths")),
        "fibre_velocity_hat": (
            both,
            s.fibre_velocity(stacked("u1", "u2")),
            _about("m/s", "estimated fibre velocities, positive when the fibre lengthens"),
        ),
        "activation_hat": (both, stacked("a1", "a2"), _about("1", "estimated activations, within [0, 1]")),
        "position_innovation": (alone, s.metres(y[:, 0] - x1), _about("m", "measured less estimated position")),
        "tendon_innovation": (
            both,
            s.metres(z - L_S),
            _about("m", "tendon length of the measured force less the estimated one"),
        ),
        "velocity_limited": (both, limited("u"), _about("1", "1 where a fibre is faster than the activation allows")),
        "activation_limited": (both, limited("a"), _about("1", "1 where the activation would be below 0 or above 1")),
        "slack": (
            ("time", "muscle"),
            (y[:, 1:] <= 0).astype(np.int8),
            _about("1", "1 where no force is measured: the tendon length is not determined"),
        ),
        "bridged": (
            ("time",),
            case.gaps[case.kept].astype(np.int8),
            _about("1", "1 where a gap of the recording was bridged"),
        ),
        # no attribute: the tables of a user's curves are longer than these may be
        "muscle_file": ((), np.array(json.dumps(muscle_file(case.pair))), {"long_name": "the muscles in SI, as JSON"}),
    }
    data |= deviations(case, results)
    for name, (unit, sentence) in TRUE.items():
        columns = [f"{name}_{j}" for j in _MUSCLES] if name in PER_MUSCLE else [name]
        if all(column in recording.true for column in columns):
            values = np.stack([recording.true[column][case.kept] for column in columns], axis=-1)
            dims = ("time", "muscle") if len(columns) > 1 else ("time",)
            data[f"true_{name}"] = (dims, values if len(columns) > 1 else values[:, 0], _about(unit, sentence))
    coordinates = {
        "time": ("time", recording.time[case.kept], {"long_name": "time", "units": "s"}),
        "observer": list(results),
        "muscle": list(_MUSCLES),
    }
    return xr.Dataset(data, coordinates, _manifest(case, results, library))


def _about(unit: str, sentence: str) -> dict[str, str]:
    return {"long_name": sentence, "units": unit}


def _manifest(case: Case, results: Mapping[str, Result], library: str) -> dict[str, str]:
    """How the estimates were made; everything as text, for NetCDF."""
    recording = case.recording
    curves = [muscle.curves for muscle in (case.pair.muscle1, case.pair.muscle2)]
    # how closely a user's tables are followed
    tables = {f"{curve_set.name}: {curve_set.sentence}": None for curve_set in curves if curve_set.name not in CURVES}
    return {
        "Conventions": "CF-1.11",
        "title": f"hillobs: estimates from {recording.source}",
        "source": recording.source,
        "notes": json.dumps([*recording.notes(), *tables]),
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
    time = case.recording.time[0] + failure.time / case.scales.rate
    likely = "the gains are too fast or unstable, or the data too wild"
    return observer_failure(name, failure, f"at {time:.4g} s", [condition.name for condition in violated], likely)
