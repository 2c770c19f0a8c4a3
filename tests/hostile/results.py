"""What of ours cases start from, results and a state: drawn again, damaged, forged, gone on with; each made once."""

from __future__ import annotations

import base64
import functools
import io
import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py

import hillobs
from hillobs.studies.files.datasets.netcdf import save_netcdf, sealed, unsealed
from places import RECORDINGS

SHORT = {"duration": 0.2, "score.start": 0.1}
RESULTS = ("run", "sweep", "estimates")
# results that reach out of their file, as only a forger makes them
FORGED = ("external", "virtual", "linked")
_ELSEWHERE = "../other/letter.txt"
# of a follower that has seen so many samples of the shipped recording
STATE = "state"
_SAMPLES = 20
_GAINS = {"high_gain.eps_h": 0.2, "high_gain.eps_L": 0.05}
_RECORDING = RECORDINGS / "dgf_smooth_noisy.csv.gz"
_MUSCLES = RECORDINGS / "dgf_smooth.toml"


@functools.cache
def result(name: str) -> bytes:
    """The file of a run, a sweep, estimates or a state."""
    if name in FORGED:
        return sealed(_reaching_out(name))
    if name == STATE:
        return base64.b64encode(_state()) + b"\n"
    match name:
        case "run":
            dataset = hillobs.simulate("paper-noisy", changes=SHORT)
        case "sweep":
            dataset = hillobs.sweep("paper-noisy", {"high_gain.eps_h": [0.05, 0.1]}, 2, changes=SHORT)
        case "estimates":
            dataset = hillobs.estimate(str(_RECORDING), str(_MUSCLES), keep_every=50)
    with tempfile.TemporaryDirectory() as folder:
        save_netcdf(dataset, Path(folder) / "x.nc")
        return (Path(folder) / "x.nc").read_bytes()


@functools.cache
def _state() -> bytes:
    follower = hillobs.follow(str(_MUSCLES), "high_gain", period=0.005, gains=_GAINS)
    recording = hillobs.read_recording(str(_RECORDING))
    for i in range(_SAMPLES):
        follower.step(*(float(values[i]) for values in recording.measured.values()), time=float(recording.time[i]))
    return follower.state()


def forged_state(changes: Mapping[str, Any]) -> bytes:
    """The file of the state with other entries and a seal that fits.

    A number in the place of a list becomes each of its numbers.
    """
    told = json.loads(unsealed(_state()) or b"")
    for name, value in changes.items():
        whole = isinstance(told.get(name), list) and isinstance(value, int | float)
        told[name] = [value] * len(told[name]) if whole else value
    return base64.b64encode(sealed(json.dumps(told).encode())) + b"\n"


def _reaching_out(how: str) -> bytes:
    """An HDF5 file that would have its reader open another one."""
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        file["failed_at"] = [0.0]
        match how:
            case "external":
                file.create_dataset("x_hat", (8,), "u1", external=[(_ELSEWHERE, 0, h5py.h5f.UNLIMITED)])
            case "virtual":
                layout = h5py.VirtualLayout((8,), "u1")
                layout[:] = h5py.VirtualSource(_ELSEWHERE, "x", (8,))
                file.create_virtual_dataset("x_hat", layout)
            case "linked":
                file["x_hat"] = h5py.ExternalLink(_ELSEWHERE, "/x")
    return content.getvalue()
