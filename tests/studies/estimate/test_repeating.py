"""A result holds all that it takes to compute it again: arguments, curves, muscles in SI."""

import json
from pathlib import Path

import pytest
import xarray as xr

from few_observers import few_observers
from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.schema import arguments as again
from hillobs.studies.files.datasets.netcdf import load, save_netcdf
from hillobs.studies.laboratory.muscles import read_muscles
from places import DATA
from shipped_recording import MUSCLES, SHIPPED, UNLIKE_MUSCLES

pytestmark = pytest.mark.numerics


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"observers": "high_gain_3", "corrected": False, "keep_every": 3},
        {"observers": "kalman", "doubt": {"optimal_fibre_length": "2%", "muscle1.force_bias": 5.0, "mass": "1%"}},
        {"observers": "kalman", "usual_doubt": False},
        {"changes": {"high_gain.eps_h": 1 / 3, "sliding_mode.tau_c": 0.2}, "mapping": {"position": "position"}},
    ],
)
def test_a_result_is_repeated_from_its_own_file(arguments: dict[str, object], tmp_path: Path) -> None:
    once = estimate(SHIPPED, MUSCLES, **arguments)
    save_netcdf(once, tmp_path / "x.nc")
    xr.testing.assert_identical(estimate(SHIPPED, **again(load(tmp_path / "x.nc"))), once)


@pytest.mark.parametrize("first", ["tables.csv", "thelen2003"])
def test_the_curves_of_unlike_muscles_are_in_the_file_too(
    first: str, unlike: tuple[Path, Path], tmp_path: Path
) -> None:
    (tmp_path / "tables.csv").write_bytes((DATA / "curves_millard_tables.csv").read_bytes())
    muscles = tmp_path / "muscles.toml"
    text = UNLIKE_MUSCLES.replace("degroote_fregly2016", first)
    muscles.write_text(text.replace("F_max = 900.0", "F_max = { value = 900.0, sd = '12%' }"))
    with few_observers("sliding_mode"):
        once = estimate(unlike[0], muscles, "sliding_mode")
        save_netcdf(once, tmp_path / "x.nc")
        for path in (tmp_path / "tables.csv", muscles):
            path.unlink()
        xr.testing.assert_identical(estimate(unlike[0], **again(load(tmp_path / "x.nc"))), once)


def test_the_muscles_of_a_result_are_told_in_SI(noisy: xr.Dataset) -> None:
    muscles = json.loads(str(noisy.muscle_file.values))
    assert (muscles["mass"], muscles["C"]) == (20.0, 0.62)
    assert muscles["muscle2"] == {
        "curves": "degroote_fregly2016",
        "F_max": 1000.0,
        "optimal_fibre_length": 0.1,
        "tendon_slack_length": 0.2,
        "v_max": 10.0,
        **read_muscles(MUSCLES).muscle2.numbers,
    }
