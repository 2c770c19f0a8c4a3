"""A sweep that is long enough has a library of its own, with its numbers in the code."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from hillobs.codegen.loop import export_loop
from hillobs.observers import OBSERVERS, estimator_of
from hillobs.studies.sweep import plan as planning
from hillobs.studies.sweep.cluster.plan_text import plan_of, text_of
from hillobs.studies.sweep.plan import plan
from hillobs.studies.sweep.run import sweep
from short_sweeps import SHORT

TRUTH, GAINS = {"plant.m": [1.0, 1.05]}, {"high_gain.eps_h": [0.1, 0.2]}
# observers that know the plant
MODELS = [name for name, observer in OBSERVERS.items() if "m" in estimator_of(observer, corrected=False).p]


@pytest.fixture
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every sweep is long enough."""
    monkeypatch.setattr(planning, "PAYS", 0)
    monkeypatch.setattr(planning, "PAYS_WITH_ONE_TRUTH", 0)


def test_runs_of_their_own_plant_pay_sooner_than_runs_that_share_it() -> None:
    """40,000 steps a run; what a sweep sets stays an argument."""
    for over, seeds, own in ((TRUTH, 6_000, False), (TRUTH, 6_300, True), (GAINS, 6_300, False), (GAINS, 63_000, True)):
        planned = plan("paper-noisy", over, seeds)
        assert (planned.loop is not planned.prepared.loop) == own, (over, seeds)
        if own:
            left = {(block.name, name) for block in planned.loop.blocks for name in block.p}
            # controller and observers take the mass of the plant for theirs, and ε_L is ε_h unless it is given
            plant = {("truth", "plant.m"), ("truth", "controller.m"), *((name, "m") for name in MODELS)}
            assert left == (plant if over is TRUTH else {("high_gain", "eps_h"), ("high_gain", "eps_L")})


@pytest.mark.usefixtures("soon")
@pytest.mark.parametrize("over", [TRUTH, GAINS], ids=["truth", "gains"])
def test_a_worker_makes_the_same_code_of_the_plan(over: dict[str, list[float]]) -> None:
    planned = plan("paper-noisy", over, 2, changes=SHORT)
    assert export_loop(plan_of(text_of(planned)).loop) == export_loop(planned.loop)


def test_results_are_the_same_but_for_rounding_and_say_which_code_ran(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Sums of squares and the step's own error: the last bit of a length, 4e−16, grows by 1e3 at most."""
    general = sweep("paper-noisy", TRUTH, 3, changes=SHORT)
    monkeypatch.setattr(planning, "PAYS", 0)
    own = sweep("paper-noisy", TRUTH, 3, changes=SHORT, out=tmp_path / "own.nc")
    assert general.attrs["code"] == "of any sweep"
    assert own.attrs["code"] == "of this sweep: its fixed numbers are written in"
    assert general.attrs["library"] != own.attrs["library"]
    for name in ("rmse", "peak", "chattering", "rmse_step_error"):
        np.testing.assert_allclose(own[name], general[name], rtol=1e-10, atol=1e3 * 4e-16, err_msg=name)
    np.testing.assert_array_equal(own.settling, general.settling)
    # the finished result is known again
    xr.testing.assert_identical(sweep("paper-noisy", TRUTH, 3, changes=SHORT, out=tmp_path / "own.nc"), own)
