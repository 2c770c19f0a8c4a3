"""Results of ours that cases start from: drawn again, damaged, forged, gone on with; each made once a process."""

from __future__ import annotations

import functools
import io
import tempfile
from pathlib import Path

import h5py

import hillobs
from hillobs.studies.files.datasets.netcdf import save_netcdf, sealed
from places import RECORDINGS

SHORT = {"duration": 0.2, "score.start": 0.1}
RESULTS = ("run", "sweep", "estimates")
# results that reach out of their file, as only a forger makes them
FORGED = ("external", "virtual", "linked")
_ELSEWHERE = "../other/letter.txt"


@functools.cache
def result(name: str) -> bytes:
    """The file of a run, a sweep or estimates."""
    if name in FORGED:
        return sealed(_reaching_out(name))
    match name:
        case "run":
            dataset = hillobs.simulate("paper-noisy", changes=SHORT)
        case "sweep":
            dataset = hillobs.sweep("paper-noisy", {"high_gain.eps_h": [0.05, 0.1]}, 2, changes=SHORT)
        case "estimates":
            dataset = hillobs.estimate(
                str(RECORDINGS / "dgf_smooth_noisy.csv.gz"), str(RECORDINGS / "dgf_smooth.toml"), keep_every=50
            )
    with tempfile.TemporaryDirectory() as folder:
        save_netcdf(dataset, Path(folder) / "x.nc")
        return (Path(folder) / "x.nc").read_bytes()


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
