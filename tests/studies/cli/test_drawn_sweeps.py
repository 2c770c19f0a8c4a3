"""`hillobs sweep` draws what it has computed, and `hillobs figures` draws it again."""

from pathlib import Path

import xarray as xr

from hillobs.studies.files.datasets.netcdf import save_netcdf
from places import contents

SWEEP = ["sweep", "paper-noisy", "--set", "duration=0.2", "--set", "score.start=0.05", "--seeds", "2"]


def test_figures_lie_beside_the_result_and_are_drawn_again(command, tmp_path: Path) -> None:
    code, out, err = command(*SWEEP, "--over", "high_gain.eps_h=0.05,0.1,0.2", "--out", "here/eps.nc")
    assert (code, err) == (0, "")
    assert "computed 6 runs in " in out
    assert out.endswith("written to here/eps.nc, eps-curves.png\n")
    first = {path.name: path.read_bytes() for path in (tmp_path / "here").glob("*.p*")}
    assert sorted(first) == ["eps-curves.png"]
    assert command("figures", "here/eps.nc", "--out", "again")[:2] == (
        0,
        "written to again/: 1 figure as PNG\n",
    )
    assert contents(tmp_path / "again") == first


def test_a_sweep_without_figures(command, tmp_path: Path) -> None:
    code, out, _ = command(*SWEEP, "--over", "plant.m=1,1.1", "--out", "m.nc", "--no-figures", "--quantity", "x2")
    assert (code, [path.name for path in tmp_path.iterdir()]) == (0, ["m.nc"])
    assert "x2" in out
    assert "Delta" not in out


def test_what_cannot_be_shown_is_said(command, tmp_path: Path) -> None:
    assert "unknown quantity 'x9'; there are x1, x2" in command(*SWEEP, "--quantity", "x9")[2]
    assert "unknown measure 'error'; there are rmse, peak" in command(*SWEEP, "--measure", "error")[2]
    save_netcdf(xr.Dataset({"rank": ("t", [4.0])}), tmp_path / "x.nc")
    code, _, err = command("figures", "x.nc")
    assert (code, err) == (2, "hillobs: x.nc cannot be drawn: it is no run, no sweep and no estimates\n")
