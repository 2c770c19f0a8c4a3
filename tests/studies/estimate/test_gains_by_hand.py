"""Gains by hand come before those of the rule; wrong ones are sentences."""

import json
from collections.abc import Mapping

import numpy as np
import pytest
import xarray as xr

from hillobs.studies.estimate.run import estimate
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.recording import Recording
from shipped_recording import MUSCLES

pytestmark = pytest.mark.numerics


def test_gains_by_hand_come_before_the_rule(noisy: xr.Dataset, short: Recording) -> None:
    estimates = estimate(short, MUSCLES, ["high_gain", "sliding_mode"], changes={"high_gain.eps_h": 0.3})
    gains = json.loads(estimates.attrs["gains"])
    rule = json.loads(estimate(short, MUSCLES).attrs["gains"])
    assert gains["high_gain"] == {**rule["high_gain"], "high_gain.eps_h": 0.3}
    assert gains["sliding_mode"] == rule["sliding_mode"]
    same = estimate(short, MUSCLES, "high_gain", changes=rule["high_gain"])
    np.testing.assert_array_equal(same.activation_hat[0], estimate(short, MUSCLES).activation_hat[0])


def test_numbers_of_both_passes_of_the_kalman_filter_stay_as_they_are_given(short: Recording) -> None:
    given = {"s_a1": 0.02, "s_a2": 0.03, "s_x3": 0.004, "s_x4": 0.005, "order_a": 2.0, "sigma_1": 0.002}
    estimates = estimate(
        short, MUSCLES, "kalman", form="a", changes={f"kalman.{name}": value for name, value in given.items()}
    )
    gains, fit = (json.loads(estimates.attrs[name])["kalman"] for name in ("gains", "fits"))
    assert {name: gains[f"kalman.{name}"] for name in given} == given
    assert list(fit["a"]["tried"]) == [f"{fit['u']['orders'][0]},2"]
    # what the second pass alone has is nothing to the first
    assert fit["u"]["numbers"].keys().isdisjoint({"s_a1", "order_a"})
    free = estimate(short, MUSCLES, "kalman", changes={"kalman.sigma_1": 0.002})
    assert fit["u"] == json.loads(free.attrs["fits"])["kalman"]["u"]
    with pytest.raises(ScenarioError, match=r"kalman.order_a must be .* 3, not 4"):
        estimate(short, MUSCLES, "kalman", changes={"kalman.order_a": 4})
    with pytest.raises(ScenarioError, match=r"unknown path 'kalman.s_a3'; the nearest are kalman.s_x3, kalman.s_a2"):
        estimate(short, MUSCLES, "kalman", changes={"kalman.s_a3": 0.1})


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"high_gain.eps": 0.1}, "unknown path 'high_gain.eps'; the nearest are high_gain.eps_h"),
        ({"eps_h": 0.1}, "'eps_h' is no gain of high_gain, sliding_mode, adaptive_sliding_mode; the muscle file"),
        ({"plant.m": 1.0}, "'plant.m' is no gain of"),
        ({"high_gain_3.eps_h": 1.0}, "'high_gain_3.eps_h' is no gain of"),
        ({"high_gain.eps_h": 0.0}, "high_gain.eps_h must be above 0, not 0"),
        ({"high_gain.eps_h": float("nan")}, "high_gain.eps_h must be a finite number, not nan"),
        ({"high_gain.eps_h": float("inf")}, "high_gain.eps_h must be a finite number, not inf"),
        (
            {"high_gain.eps_h": 1e-20},
            "the gains of high_gain are too fast for samples τ = 0.05 apart: they ask for 6.67e+",
        ),
        ({"sliding_mode.delta_L": 0.0}, "sliding_mode.delta_L = 0 has no fastest rate"),
    ],
)
def test_wrong_gains_are_sentences(changes: Mapping[str, float], sentence: str, short: Recording) -> None:
    with pytest.raises(ScenarioError) as caught:
        estimate(short, MUSCLES, changes=changes)
    assert str(caught.value).startswith(sentence)
    assert len(str(caught.value)) < 300
