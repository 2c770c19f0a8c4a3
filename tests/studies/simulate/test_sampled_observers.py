"""What moves at samples only is scored at samples, in a recorded run and in a sweep alike; the Kalman filter is one."""

import numpy as np
import pytest

import hillobs
from hillobs.model.symbols import STATES

pytestmark = pytest.mark.numerics

# recorded at each sample
SHORT = {"duration": 3.0, "record": 0.005, "score.start": 1.0}


def test_errors_of_a_sampled_observer_count_at_the_samples() -> None:
    # both tendons go slack for a while
    changes = {**SHORT, "duration": 6.0, "score.start": 2.001}
    run = hillobs.simulate("slack-deep", ["kalman"], changes)
    at = run.time >= changes["score.start"]
    of = run.sel(observer="kalman", estimator="kalman")
    for i, state in enumerate(STATES):
        counted = at & (run.taut.isel(muscle=i - 2) > 0 if state in ("x3", "x4") else True)
        error = (of.x_hat - run.x).sel(state=state).where(counted, drop=True)
        assert float(of.rmse.sel(quantity=state)) == pytest.approx(float(np.sqrt((error**2).mean())), rel=1e-12)
        slack = 0.005 * int((at & ~counted).sum())
        assert float(of.masked.sel(quantity=state)) == pytest.approx(slack, abs=1e-12)


def test_a_sweep_scores_it_as_a_recorded_run_does() -> None:
    swept = hillobs.sweep("paper-noisy", {"kalman.s_D": [1e-3, 1e-2]}, seeds=2, changes=SHORT)
    run = hillobs.simulate("paper-noisy", ["kalman"], {**SHORT, "kalman.s_D": 1e-2, "seed": 1})
    for measure in ("rmse", "peak", "settling", "chattering"):
        here = swept[measure].sel(observer="kalman", seed=1).isel({"kalman.s_D": 1})
        np.testing.assert_array_equal(here, run[measure].sel(estimator="kalman"))


@pytest.mark.parametrize(
    ("scenario", "bounds"),
    [
        ("paper-noisy", {"x2": 4.9e-4, "Delta": 1.4e-3, "u1": 5.8e-4, "a1": 6.2e-3}),
        ("challenge", {"x2": 1.2e-3, "Delta": 5.9e-3, "u1": 1.35e-3, "a1": 4.1e-3}),
    ],
)
def test_it_is_as_good_as_promised_in_the_median(scenario: str, bounds: dict[str, float]) -> None:
    rmse = hillobs.sweep(scenario, seeds=12, observers=["kalman"]).rmse.sel(observer="kalman").median("seed")
    found = {name: float(rmse.sel(quantity=name)) for name in bounds}
    assert all(found[name] < bound for name, bound in bounds.items()), found


def test_results_have_standard_deviations_only_of_observers_that_tell_them() -> None:
    run = hillobs.simulate("paper-noisy", ["high_gain", "kalman"], SHORT)
    for name in ("x", "u", "a", "Delta"):
        deviations = run[f"{name}_sd"]
        assert deviations.dims == run[f"{name}_hat"].dims
        assert np.isnan(deviations.sel(observer="high_gain")).all()
        assert (deviations.sel(observer="kalman") > 0).all()
    assert not [name for name in hillobs.simulate("paper-noisy", ["high_gain"], SHORT) if name.endswith("_sd")]
    # the inner states of a filter are no part of a result
    assert [name for name in run if name.startswith("kalman_")] == [
        "kalman_dDelta_hat", "kalman_ddDelta_hat", "kalman_du1_hat", "kalman_ddu1_hat", "kalman_du2_hat",
        "kalman_ddu2_hat",
    ]  # fmt: skip


def test_95_percent_of_the_errors_are_within_1_96_standard_deviations() -> None:
    """Without the drift, which the filter does not know of; of the states whose model is right, medians of runs."""
    covered = []
    for seed in range(5):
        run = hillobs.simulate("paper-noisy", ["kalman"], {"noise.drift": 0.0, "seed": seed}).sel(observer="kalman")
        late = run.sel(time=slice(2, None))
        parts = [abs(late[f"{name}_hat"] - late[name]) < 1.96 * late[f"{name}_sd"] for name in ("x", "u", "a", "Delta")]
        covered.append([float(part.mean()) for part in parts])
    assert (np.median(covered, axis=0) > 0.9).all(), covered


@pytest.mark.parametrize("order", ["1.5", "0", "4"])
def test_an_order_is_1_2_or_3(order: str) -> None:
    with pytest.raises(hillobs.Error, match=r"kalman.order_u must be (a whole number|at least 1|at most 3), not"):
        hillobs.simulate("paper-noisy", ["kalman"], {"kalman.order_u": float(order)})
