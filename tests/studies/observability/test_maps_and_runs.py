"""Ranks over a map of points and along a run."""

import numpy as np
import pytest

from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.observability.map import along, over
from hillobs.studies.observability.point import start_point
from hillobs.studies.observability.question import pose
from hillobs.studies.scenarios.prepare import prepare


def test_a_map_begins_slack_and_takes_the_tolerance() -> None:
    prepared = prepare("paper-clean", None, {})
    question, point = pose(prepared, unknown="u", order=2), start_point(prepared)
    data = over(question, ("x1", "tension"), point, points=24)
    assert (data["rank"].where(data.tension <= 0, drop=True) == 3).all()
    assert (data["rank"].where(data.tension > 0.05, drop=True) == 7).all()
    assert (over(question, ("x3", "x4"), point, points=5, tolerance=0.5)["rank"] < 7).all()


def test_along_a_run_the_rank_falls_exactly_while_a_tendon_is_slack() -> None:
    prepared = prepare("slack", None, {"duration": 8.0})
    data = along(prepared, pose(prepared, unknown="u", order=2))
    slack = (data.taut == 0).sum("muscle")
    np.testing.assert_array_equal(data["rank"], 7 - 2 * slack)
    with pytest.raises(ScenarioError, match="no run to look along: the plant"):
        along(prepare("paper-clean", None, {"initial.x2": -40.0}), pose(prepared))
