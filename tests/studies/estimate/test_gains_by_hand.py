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
            "the gains of high_gain are too fast for samples 0.05 apart: they ask for 6.67e+",
        ),
        ({"sliding_mode.delta_L": 0.0}, "sliding_mode.delta_L = 0 has no fastest rate"),
    ],
)
def test_wrong_gains_are_sentences(changes: Mapping[str, float], sentence: str, short: Recording) -> None:
    with pytest.raises(ScenarioError) as caught:
        estimate(short, MUSCLES, changes=changes)
    assert str(caught.value).startswith(sentence)
    assert len(str(caught.value)) < 300
