"""The runs of a sweep that say how good its step is."""

import numpy as np
import pytest
import xarray as xr

from hillobs.observers.score import MEASURES
from hillobs.studies.cli.reports.sweep import notes, step_table
from hillobs.studies.simulate.run import simulate
from hillobs.studies.simulate.step_error import error_of
from hillobs.studies.sweep.plan import plan
from hillobs.studies.sweep.run import sweep
from short_sweeps import SHORT, printed


@pytest.mark.parametrize("runs", [1, 2, 15, 16, 17, 31, 1000, 10**8])
def test_the_sample_is_spread_evenly_from_the_first_run_to_the_last(runs: int) -> None:
    sample = plan("paper-noisy", {}, runs).sample()
    assert (sample[0], sample[-1], len(sample)) == (0, runs - 1, min(runs, 16))
    if runs > 1:
        steps = np.diff(sample)
        assert steps.min() >= 1
        assert steps.max() - steps.min() <= 1


def test_the_error_of_a_run_is_that_of_the_run_alone() -> None:
    """Also where the step itself is swept: each run has its own half."""
    over = {"step": [5e-4, 1e-3], "high_gain.eps_h": [0.1, 0.2]}
    swept = sweep("paper-noisy", over, 3, changes=SHORT)
    assert swept.sampled.values.tolist() == list(range(12))
    for number in (0, 5, 11):
        step, eps, seed = np.unravel_index(number, (2, 2, 3))
        changes = {**SHORT, "step": over["step"][step], "high_gain.eps_h": over["high_gain.eps_h"][eps], "seed": seed}
        run = simulate("paper-noisy", changes=changes).sel(estimator=swept.observer.values)
        for measure in MEASURES:
            found = swept[error_of(measure)].sel(sampled=number)
            np.testing.assert_array_equal(found, run[error_of(measure)], err_msg=f"{measure} of run {number}")


def test_a_small_error_is_one_sentence(layer: xr.Dataset) -> None:
    fine = layer.copy(deep=True)
    fine.rmse_step_error[:] = 1e-4 * fine.rmse.values.reshape(-1, *fine.rmse.shape[-2:])[fine.sampled.values]
    assert not list(step_table(fine))
    (sentence,) = (note for note in notes(fine) if note.startswith("error of the step"))
    assert "at most 0.01 % of an RMSE" in sentence
    assert sentence.endswith("tried in 15 of 15 runs")


def test_a_large_error_is_in_a_table_with_the_runs_that_have_it(layer: xr.Dataset) -> None:
    coarse = layer.copy(deep=True)
    rmse = coarse.rmse.values.reshape(-1, *coarse.rmse.shape[-2:])[coarse.sampled.values]
    coarse.rmse_step_error[:] = 1e-4 * rmse
    x2 = list(coarse.quantity.values).index("x2")
    coarse.rmse_step_error[:, 1, x2] = 0.03 * rmse[:, 1, x2]
    coarse.rmse_step_error[-1, 1, x2] = np.inf  # it fails at half the step
    (table,) = step_table(coarse)
    (row,) = (line for line in printed(table) if line.startswith(("HGO", "SMO")))
    assert row.split() == ["HGO", "x2", "∞", str(np.isfinite(rmse[:, 1, x2]).sum())]
    assert any("at most ∞ of an RMSE (HGO x2)" in note for note in notes(coarse))


def test_lost_runs_have_no_error_and_break_no_table(line: xr.Dataset) -> None:
    """The smallest ε_h of this sweep fail at both steps."""
    lost = np.isnan(line.rmse.values.reshape(-1, *line.rmse.shape[-2:])[line.sampled.values])
    assert lost.any()
    for table in step_table(line):
        assert "nan" not in "\n".join(printed(table))
    assert "nan" not in "\n".join(notes(line))
