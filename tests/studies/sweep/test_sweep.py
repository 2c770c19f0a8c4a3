"""Sweeps: what they vary, what they find, and what they refuse."""

from pathlib import Path

import numpy as np
import pytest

from few_observers import few_observers
from hillobs.studies.files.errors import ResultError, ScenarioError
from hillobs.studies.simulate.run import simulate
from hillobs.studies.sweep.axes import Range, axes, parse_axis
from hillobs.studies.sweep.run import sweep

pytestmark = pytest.mark.numerics

SHORT = {"duration": 0.2, "score.start": 0.05}
EPS = {"high_gain.eps_h": Range(0.02, 0.5, 5, logarithmic=True)}


def test_a_point_of_a_sweep_is_the_run_of_that_scenario() -> None:
    found = sweep("paper-noisy", {"high_gain.eps_h": [0.05, 0.2], "plant.m": [1.0, 1.3]}, seeds=[3, 9], changes=SHORT)
    assert found.rmse.dims == ("high_gain.eps_h", "plant.m", "seed", "observer", "quantity")
    for eps in (0.05, 0.2):
        for m in (1.0, 1.3):
            alone = simulate("paper-noisy", None, {**SHORT, "high_gain.eps_h": eps, "plant.m": m, "seed": 9})
            point = found.sel({"high_gain.eps_h": eps, "plant.m": m, "seed": 9})
            for measure in ("rmse", "peak", "settling", "chattering"):
                np.testing.assert_array_equal(
                    point[measure].values, alone[measure].sel(estimator=found.observer.values).values
                )


def test_the_trade_off_of_the_high_gain_observer_has_its_optimum_where_it_was_found() -> None:
    """Near 0.2 for x₂ and Δ, near 0.1 for u and a; worse on both sides."""
    found = sweep("paper-noisy", {"high_gain.eps_h": Range(0.02, 0.5, 11, logarithmic=True)}, seeds=8)
    median = found.rmse.median("seed").sel(observer="high_gain")
    best = median.idxmin("high_gain.eps_h")
    for quantity, low, high in (("x2", 0.15, 0.3), ("Delta", 0.15, 0.3), ("u1", 0.06, 0.15), ("a1", 0.06, 0.15)):
        assert low <= float(best.sel(quantity=quantity)) <= high
        curve = median.sel(quantity=quantity).values
        assert curve[0] > 1.5 * curve.min() < curve[-1]


def test_the_step_and_the_duration_can_be_swept() -> None:
    found = sweep("paper-noisy", {"duration": [0.2, 0.4], "step": [5e-4, 1e-3]}, changes={"score.start": 0.05})
    alone = simulate("paper-noisy", None, {"score.start": 0.05, "duration": 0.4, "step": 1e-3})
    np.testing.assert_array_equal(
        found.sel({"duration": 0.4, "step": 1e-3, "seed": 0}).rmse, alone.rmse.sel(estimator=found.observer.values)
    )


def test_axes_can_go_together() -> None:
    found = sweep("paper-clean", {"high_gain.eps_h": [0.1, 0.2], "high_gain.h11": [3, 4]}, kind="zip", changes=SHORT)
    assert found.rmse.dims == ("point", "seed", "observer", "quantity")
    assert found["high_gain.h11"].values.tolist() == [3, 4]


@pytest.mark.parametrize("kind", ["latin", "sobol"])
def test_a_design_fills_the_ranges(kind: str) -> None:
    made = axes({"a": Range(0, 1), "b": Range(0.01, 1, logarithmic=True)}, kind, 64)
    for values, low, high in zip(made.values, (0, 0.01), (1, 1), strict=True):
        assert low <= values.min() < values.max() <= high
    # one sample in each of 64 equal strips
    assert len(np.unique(np.floor(made.values[0] * 64))) == 64


def test_a_range_has_its_ends() -> None:
    (values,) = axes(dict([parse_axis("x=log:0.02:0.5:25")])).values
    assert (values[0], values[-1], len(values)) == (0.02, 0.5, 25)
    np.testing.assert_allclose(values[1:] / values[:-1], (0.5 / 0.02) ** (1 / 24), rtol=1e-12)


@pytest.mark.parametrize(
    ("over", "seeds", "words"),
    [
        ({"high_gain.eps_h": []}, 1, "1 to 1,000,000 values"),
        ({"high_gain.eps_h": Range(0, 1, 3, logarithmic=True)}, 1, "needs ends above 0"),
        ({"high_gain.eps_h": Range(2, 1, 3)}, 1, "is empty"),
        ({"high_gain.eps_g": [1]}, 1, "unknown path"),
        ({"high_gain.eps_h": [0.1, -1]}, 1, "must be above 0"),
        ({"high_gain.eps_h": [0.1, 0.1]}, 1, "a value twice"),
        ({"muscle.k": [19, 40]}, 1, "at muscle.k = 40"),
        ({"step": [5e-4, 3e-4]}, 1, "at step = 0.0003"),
        ({"seed": [1]}, 1, "use seeds"),
        ({}, 0, "seeds must be a whole number from 1"),
        ({}, [1, 1], "a seed is there twice"),
        ({}, [-1], "whole number from 0"),
    ],
)
def test_what_cannot_be_swept_is_said(over, seeds, words) -> None:
    with pytest.raises(ScenarioError, match=words):
        sweep("paper-clean", over, seeds, changes=SHORT)


def test_a_result_of_another_sweep_is_not_overwritten(tmp_path: Path) -> None:
    sweep("paper-clean", EPS, changes=SHORT, out=tmp_path / "x.nc")
    before = (tmp_path / "x.nc").read_bytes()
    with pytest.raises(ResultError, match="result of something else"):
        sweep("paper-clean", EPS, 2, changes=SHORT, out=tmp_path / "x.nc")
    assert (tmp_path / "x.nc").read_bytes() == before


def test_what_is_not_asked_for_is_not_scored_and_changes_nothing() -> None:
    """Another library: a compiler may contract a product and a sum here and not there."""
    every = sweep("paper-noisy", EPS, 3, "high_gain", SHORT)
    with few_observers("high_gain"):
        few = sweep("paper-noisy", EPS, 3, "high_gain", SHORT, quantities=["Delta", "x2"], measures=["chattering"])
    assert few.quantity.values.tolist() == ["x2", "Delta"]
    assert [name for name in few.data_vars if "quantity" in few[name].dims] == [
        *("rmse", "chattering"),
        *("rmse_step_error", "chattering_step_error"),
    ]
    for measure in ("rmse", "chattering"):
        np.testing.assert_allclose(few[measure], every[measure].sel(quantity=few.quantity), rtol=1e-10)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"quantities": ["x5"]}, "unknown quantity 'x5'; there are x1, x2"),
        ({"quantities": []}, "at least one quantity"),
        ({"measures": ["error"]}, "unknown measure 'error'; there are rmse, peak"),
    ],
)
def test_what_cannot_be_scored_is_said(asked, words) -> None:
    with pytest.raises(ScenarioError, match=words):
        sweep("paper-clean", EPS, changes=SHORT, **asked)


@pytest.mark.parametrize(
    ("path", "asked"),
    [
        ("sliding_mode.delta_s", {"observers": "high_gain"}),
        ("activation1.offset", {}),
        ("high_gain.u_high", {"quantities": ["x2"]}),
        ("score.tolerance.x2", {"measures": ["peak"]}),
    ],
)
def test_an_axis_that_changes_nothing_is_refused(path, asked) -> None:
    with pytest.raises(ScenarioError, match=f"{path} changes nothing here"):
        sweep("paper-clean", {path: [0.01, 0.02]}, changes=SHORT, **asked)
