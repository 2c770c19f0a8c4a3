"""`hillobs observability` answers with its exit code: 0 observable, 1 not."""

import json
from pathlib import Path

import numpy as np
import xarray as xr

from hillobs.studies.cli.reports.observability import ranks_along
from places import contents


def test_observability_answers_with_its_exit_code(command, tmp_path: Path) -> None:
    code, out, _ = command("observability", "--unknown", "u")
    assert code == 0
    assert "rank 7 of 7, observable" in out
    code, out, _ = command("observability", "--unknown", "a", "--at", "x3=1.99", "--json")
    assert code == 1
    answer = json.loads(out)
    assert {key: answer[key] for key in ("rank", "n", "structural_rank", "unobservable")} == {
        "rank": 5,
        "n": 7,
        "structural_rank": 7,
        "unobservable": ["x3", "a1"],
    }
    code, out, _ = command("observability", "--at", "x3=2")
    assert code == 1
    assert "warning: the derivatives jump at x3 = 2 (rank 3 below, 4 above)" in out
    code, out, _ = command(
        "observability", "slack", "--set", "duration=8", "--along", "--map", "x1,tension", "--out", "o"
    )
    assert code == 0
    assert "along the run, rank 4 for 6." in out
    assert "over the map, rank 4 on 9" in out
    assert len(contents(tmp_path / "o")) == 4


def test_the_times_of_all_ranks_add_up_to_the_run() -> None:
    time = np.linspace(0.0, 0.5, 6)
    data = xr.Dataset({"rank": ("time", [4, 4, 3, 4, 4, 4])}, {"time": time})
    assert ranks_along(data) == "rank 4 for 0.4, 3 for 0.1"
    assert ranks_along(data.isel(time=slice(1))) == "rank 4 for 0"
