"""How well a coordinate can be known from noisy samples: that of a fitted line, and none where nothing is seen."""

import numpy as np

from hillobs.model.block import Block, Symbols, symbols
from hillobs.studies.observability.information import deviations
from hillobs.studies.observability.point import answer
from hillobs.studies.observability.question import pose
from hillobs.studies.scenarios.prepare import prepare
from observed_systems import TAUT


def test_the_accuracy_is_that_of_a_linear_system_in_closed_form() -> None:
    """ẋ = v, v̇ = 0, position sampled: the variance of a line fitted to N samples."""
    x = symbols("x v")
    line = Block("line", x=x, dx=Symbols(x=x.v, v=x.x * 0), y=Symbols(x=x.x))
    period, samples, half_width = 0.01, 100, 1e-3
    t = period * np.arange(samples)
    design = np.stack([np.ones(samples), t], axis=1)
    expected = np.sqrt(np.diag(np.linalg.inv(design.T @ design)) * half_width**2 / 3)
    computed = deviations(line, ([0.0, 0.0], []), [], {"x": half_width}, {"x": 1.0, "v": 1.0}, period)
    np.testing.assert_allclose(list(computed.values()), expected, rtol=1e-9)


def test_what_leaves_no_trace_has_no_accuracy() -> None:
    """Both tendons slack for good: neither length is known, however long one waits."""
    question = pose(prepare("paper-clean", None, {}), unknown="u")
    spread = answer(question, {**TAUT, "x3": 1.9, "x4": 1.9, "u1": 0.0, "u2": 0.0, "x2": 0.0, "Delta": 0.0}).deviations
    assert {name for name, value in spread.items() if np.isinf(value)} == {"x3", "x4", "u1", "u2"}
    assert all(value < 1e-2 for name, value in spread.items() if name in ("x1", "x2", "Delta"))
