"""The shipped noisy recording, its parts and the errors of its estimates; files of muscles and of mechanisms."""

import dataclasses
from pathlib import Path

import xarray as xr

from hillobs.observers import OBSERVERS
from hillobs.studies.estimate.scores import scores
from hillobs.studies.files.tables import Series, write_csv
from hillobs.studies.laboratory.recording import Recording
from places import RECORDINGS

SHIPPED, MUSCLES = RECORDINGS / "dgf_smooth_noisy.csv.gz", RECORDINGS / "dgf_smooth.toml"
ALL_OBSERVERS = list(OBSERVERS)
HINGE, DYNAMOMETER = RECORDINGS / "hinge_pair.toml", RECORDINGS / "dynamometer.toml"
CHAINS = ("high_gain", "high_gain_3", "kalman_constant", "levant", "sliding_mode", "adaptive_sliding_mode")

UNLIKE_MUSCLES = """
mass = 12.0
C = 0.5
[muscle1]
curves = "degroote_fregly2016"
F_max = 1500.0
optimal_fibre_length = 0.08
tendon_slack_length = 0.16
v_max = 8.0
[muscle2]
curves = "thelen2003"
F_max = 900.0
optimal_fibre_length = 0.1
tendon_slack_length = 0.15
v_max = 10.0
damping = 0.1
"""


def part(whole: Recording, which: object, **changes: object) -> Recording:
    cut = {"time": whole.time[which], "rows": whole.rows[which]}
    measured = {name: values[which] for name, values in whole.measured.items()}
    return dataclasses.replace(whole, **{**cut, "measured": measured, "true": {}, **changes})


def write_measured(recording: Recording, path: Path) -> None:
    """What was measured, as CSV."""
    units = {"time": "s", "position": "m", "force_1": "N", "force_2": "N"}
    columns = {"time": recording.time, **recording.measured}
    write_csv(path, [Series(name, units[name], values) for name, values in columns.items()])


def rmse(dataset: xr.Dataset, quantity: str) -> dict[str, float]:
    return {s.observer: s.rmse for s in scores(dataset) if s.quantity == quantity and s.muscle in ("", "both")}
