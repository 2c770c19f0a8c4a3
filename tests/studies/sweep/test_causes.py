"""Why runs of a sweep failed: the cause and time of each, and where in the sweep they are."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from hillobs.studies.cli.reports.sweep import notes
from hillobs.studies.files.datasets.netcdf import load, save_netcdf
from hillobs.studies.simulate.run import simulate
from hillobs.studies.sweep.axes import Axes
from hillobs.studies.sweep.region import where
from hillobs.studies.sweep.run import sweep
from short_sweeps import EPS, SHORT, cause


def test_a_failure_has_the_cause_and_the_time_that_the_run_alone_has(line: xr.Dataset) -> None:
    for eps in EPS:
        alone = simulate("paper-noisy", "high_gain", {**SHORT, "high_gain.eps_h": eps, "seed": 2})
        point = line.sel({"high_gain.eps_h": eps, "seed": 2, "observer": "high_gain"})
        said = json.loads(alone.attrs["failures"]).get("high_gain")
        if said is None:
            assert np.isnan(point.failed_at)
            assert cause(point.failure) == "none"
        else:
            assert said.startswith(f"high_gain: {cause(point.failure)} is not a number within ±")
            assert f"at τ = {float(point.failed_at):g};" in said
    assert line.failure.sel({"high_gain.eps_h": 5e-5, "observer": "high_gain"}).all()


def test_a_plant_that_fails_says_which_length_left_its_domain() -> None:
    swept = sweep("paper-clean", {"initial.x1": [2.6, 5.0]}, 2, "high_gain", SHORT)
    assert [cause(code) for code in swept.plant_failure.isel(seed=1)] == ["none", "L_C2"]
    assert not swept.failure.any()
    assert "commonest cause: L_C2 (2 runs), at 1 of 2 points, all with initial.x1 = 5" in "\n".join(notes(swept))


def test_causes_are_kept_in_a_file(line: xr.Dataset, tmp_path: Path) -> None:
    save_netcdf(line, tmp_path / "x.nc")
    xr.testing.assert_identical(line, load(tmp_path / "x.nc"))
    flags = line.failure.attrs
    assert len(flags["flag_values"]) == len(flags["flag_meanings"].split())


def test_the_report_names_the_commonest_cause(line: xr.Dataset) -> None:
    of = line.sel(observer="high_gain")
    lost = int(of.failed_at.notnull().sum())
    causes = [cause(code) for code in of.failure.stack(run=of.failure.dims)]
    names, counts = np.unique([name for name in causes if name != "none"], return_counts=True)
    said = "\n".join(notes(line))
    assert f"HGO failed in {lost} of them" in said
    assert any(f"commonest cause: {name} ({counts.max()} runs), at " in said for name in names[counts == counts.max()])


@pytest.mark.parametrize(
    ("chosen", "words"),
    [
        ([0, 1, 2], "at 3 of 6 points, all with a = 1"),
        ([0, 3], "at 2 of 6 points, all with b = 10"),
        ([1, 2], "at 2 of 6 points, all with a = 1, b ≥ 20"),
        ([0, 1, 3, 4], "at 4 of 6 points, all with b ≤ 20"),
        ([0, 5], "at 2 of 6 points"),
        ([0, 1, 2, 3, 4, 5], "at every point"),
    ],
)
def test_a_region_is_said_by_its_ends(chosen: list[int], words: str) -> None:
    mask = np.zeros(6, dtype=bool)
    mask[chosen] = True
    assert where(Axes("grid", ("a", "b"), (np.array([1.0, 2.0]), np.array([10.0, 20.0, 30.0]))), mask) == words
