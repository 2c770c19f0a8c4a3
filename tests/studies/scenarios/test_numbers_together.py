"""Numbers that are right alone and wrong together: times off the grid, too many steps, muscles without an inverse."""

import pytest

from documents import refusal
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.scenarios.prepare import prepare


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"step": 30.0}, "step = 30 must not exceed duration = 20"),
        ({"step": 3e-4}, "must be a whole multiple of step = 0.0003"),
        ({"record": 0.0007}, "record = 0.0007 must be a whole multiple of step"),
        ({"noise.period": 0.0033}, "noise.period = 0.0033 must be a whole multiple"),
        ({"pulse1.start": 0.12345}, "pulse1.start = 0.12345 must be a whole multiple"),
        ({"duration": 1e12}, "more than 1,000,000,000 steps"),
        ({"duration": 1e5}, "keeps more than 1,000,000 points"),
        ({"muscle.k": 40.0}, "muscle1: k·toe = 1.6 must be below 2.5 F_toe = 1.25"),
        ({"high_gain.muscle2.k": 40.0}, "high_gain.muscle2: k·toe"),
    ],
)
def test_numbers_that_do_not_fit_together_are_named(changes: dict[str, float], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        prepare("paper-clean", None, changes)


@pytest.mark.parametrize("path", ["score.start", "noise.period", "record", "pulse1.start", "pulse2.stop"])
def test_a_time_beyond_every_integer_is_refused_or_right(path: str) -> None:
    """The kernel counts steps in 64 bits; what does not fit must not wrap around."""
    changes = {path: 1e30}
    if sentence := refusal(lambda: prepare("paper-noisy", None, changes)):
        assert path in sentence
        return
    grid = prepare("paper-noisy", None, changes).grid
    assert all(abs(n) < 2**63 for n in (grid.record, grid.hold, grid.window, *sum(grid.pulses, ())))


def test_a_period_far_below_the_step_is_no_way_to_switch_the_noise_off() -> None:
    with pytest.raises(ScenarioError, match=r"noise\.period"):
        prepare("paper-noisy", None, {"noise.period": 1e-14})


def test_a_pulse_that_ends_before_it_begins_is_refused() -> None:
    with pytest.raises(ScenarioError, match="pulse1"):
        prepare("paper-clean", None, {"pulse1.start": 3.0, "pulse1.stop": 2.0})


@pytest.mark.parametrize("value", [1.5, 2.0])
def test_a_force_factor_at_the_pole_is_refused(value: float) -> None:
    """g⁻¹ has its pole at g_max = 1.5; beyond it a muscle that lengthens comes out as one that shortens."""
    with pytest.raises(ScenarioError, match=r"^muscle1\.z_max = .*the pole of g⁻¹$"):
        prepare("activation", None, {"muscle.z_max": value})
    with pytest.raises(ScenarioError, match=r"^muscle2\.z_max = .*the pole of g⁻¹$"):
        prepare("activation", None, {"muscle2.z_max": value})
