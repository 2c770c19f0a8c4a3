"""Results as someone might forge them, given to `hillobs figures`: drawn, or refused in a sentence; by `make chaos`."""

import os
import random
import warnings
from pathlib import Path

import pytest
import xarray as xr

from forgeries import mutations
from hillobs import Error, estimate, simulate, sweep
from hillobs.studies.files.datasets.netcdf import save_netcdf
from places import RECORDINGS

pytestmark = pytest.mark.chaos

# of some thousands; one that is drawn takes seconds
FORGED = int(os.environ.get("FORGED", "60"))
SHORT = {"duration": 0.2, "score.start": 0.1}


def result(kind: str) -> xr.Dataset:
    match kind:
        case "run":
            return simulate("paper-noisy", changes=SHORT)
        case "sweep":
            return sweep("paper-noisy", {"high_gain.eps_h": [0.05, 0.1], "noise.x1": [0.0, 1e-3]}, 2, changes=SHORT)
    return estimate(RECORDINGS / "dgf_smooth_noisy.csv.gz", RECORDINGS / "dgf_smooth.toml", keep_every=50)


@pytest.mark.parametrize("kind", ["run", "sweep", "estimates"])
def test_a_forged_result_is_drawn_or_refused_in_a_sentence(kind: str, command, tmp_path: Path, record_property) -> None:
    good = result(kind)
    ends = []
    for what, change in random.Random(2).sample(list(mutations(good)), FORGED):
        path = tmp_path / "x.nc"
        path.unlink(missing_ok=True)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # xarray's on odd values
                save_netcdf(change(good), path)
        except (Error, TypeError, ValueError):
            continue  # nothing that could be in a file
        code, _, err = command("figures", "x.nc", "--out", "out")
        assert code in (0, 2), (what, err)
        assert code == 0 or err.startswith("hillobs: x.nc cannot be "), what
        assert all(line.isprintable() for line in err.splitlines()), what
        ends.append(code)
    assert {0, 2} <= set(ends)
    record_property("faults", len(ends))
