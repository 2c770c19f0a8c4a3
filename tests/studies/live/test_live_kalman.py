"""Live the Kalman filter is a close relative of the one that a recording is given to."""

import numpy as np
import pytest

import hillobs
from hillobs import Recording
from live_samples import QUANTITIES, numbers, rows, stepped
from shipped_recording import MUSCLES, SHIPPED

# what the form `u` of a recording differs by in its slopes, as a part of what noise and inputs leave open
NEAR = 0.15


@pytest.fixture(scope="module")
def recording() -> Recording:
    return hillobs.read_recording(SHIPPED)


# its library is one that no other test compiles
@pytest.mark.chaos
def test_the_kalman_filter_is_near_that_of_the_recording_and_as_sure(recording: Recording) -> None:
    estimates = hillobs.estimate(recording, MUSCLES, "kalman", form="u").isel(observer=0)
    told = stepped(hillobs.follow(MUSCLES, "kalman", gains=estimates), rows(recording))
    for quantity in QUANTITIES:
        sd = estimates[f"{quantity}_sd_state"].values
        apart = np.abs(numbers(told, quantity) - estimates[f"{quantity}_hat"].values)
        # where a tendon may be slack neither is sure of anything
        assert (apart[np.isfinite(sd)] <= NEAR * sd[np.isfinite(sd)]).all(), quantity
        own = np.array([list(v.values()) if isinstance(v, dict) else v for v in (e.sd[quantity] for e in told)])
        np.testing.assert_allclose(own, sd, rtol=NEAR, equal_nan=True)


@pytest.mark.chaos
def test_gains_of_both_forms_are_taken_and_a_state_goes_on(recording: Recording) -> None:
    estimates = hillobs.estimate(recording, MUSCLES, "kalman", form="a")
    samples = rows(recording)[:200]
    without = hillobs.follow(MUSCLES, "kalman", gains=estimates)
    told = stepped(without, samples)
    follower = hillobs.follow(MUSCLES, "kalman", gains=estimates)
    again = stepped(follower, samples[:100])
    follower = hillobs.follow(MUSCLES, "kalman", state=follower.state())
    assert repr([*again, *stepped(follower, samples[100:])]) == repr(told)
