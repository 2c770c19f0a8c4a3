"""Every command that writes files, in its shortest form, with what it needs to read."""

import gzip
from pathlib import Path

from places import DATA, RECORDINGS

_SHORT = ["--set", "duration=0.1", "--set", "score.start=0.02", "--observer", "high_gain"]
_SWEEP = ["sweep", "run.toml", *_SHORT, "--quantity", "x2", "--over", "high_gain.eps_h=0.1,0.2"]
_ESTIMATE = [
    "estimate",
    "short.csv",
    "--muscles",
    "pair.toml",
    "--observer",
    "high_gain",
    "--every",
    "20",
    "--report",
    "--out",
    ".",
]
_OBSERVABILITY = ["observability", "--order", "1", "--out", "."]

# name → command; all write into the current folder
WRITERS = {
    "simulate": ["simulate", "run.toml", *_SHORT, "--out", "."],
    "sweep over one": [*_SWEEP, "--out", "x.nc"],
    "sweep over two": [*_SWEEP, "--over", "plant.m=1,2", "--out", "x.nc"],
    "estimate": _ESTIMATE,
    "along": [*_OBSERVABILITY, "run.toml", "--along", "--set", "duration=0.1", "--set", "score.start=0.02"],
    "map": [*_OBSERVABILITY, "run.toml", "--map", "x3,x4"],
    "curves": ["curves", "--out", "."],
    "import": ["import", "model.osim", "--out", "arm.toml"],
}


def inputs(folder: Path) -> set[str]:
    """Put what the commands read into a folder; the names."""
    (folder / "run.toml").write_text('base = "paper-noisy"\n')
    (folder / "pair.toml").write_bytes((RECORDINGS / "dgf_smooth.toml").read_bytes())
    rows = gzip.decompress((RECORDINGS / "dgf_smooth_noisy.csv.gz").read_bytes()).splitlines(keepends=True)
    # more than the second that observers settle in: there are scores
    (folder / "short.csv").write_bytes(b"".join(rows[:300]))
    (folder / "model.osim").write_bytes((DATA / "arm26_polynomial.osim").read_bytes())
    return {"run.toml", "pair.toml", "short.csv", "model.osim"}
