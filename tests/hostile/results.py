"""Results of ours that cases start from: drawn again, damaged, forged, gone on with; each made once a process."""

from __future__ import annotations

import functools
import tempfile
from pathlib import Path

import hillobs
from hillobs.studies.files.netcdf import save_netcdf
from places import RECORDINGS

SHORT = {"duration": 0.2, "score.start": 0.1}
RESULTS = ("run", "sweep", "estimates")


@functools.cache
def result(name: str) -> bytes:
    """The file of a run, a sweep or estimates."""
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
