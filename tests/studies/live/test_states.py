"""A follower that was saved goes on as if nothing had been; bytes of others are refused, whatever is in them."""

import json
import math
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hillobs
from hillobs import Recording, ResultError
from hillobs.studies.files.datasets.netcdf import sealed, unsealed
from live_samples import rows, stepped
from shipped_recording import HINGE, MUSCLES

PERIOD = 0.005
GAINS = {"high_gain.eps_h": 0.2, "high_gain.eps_L": 0.05}


# before the first sample, while gains are learnt, when they are, after the gap, and some in between
@pytest.mark.parametrize("cuts", [[0, 1, 60, 119, 120, 121, 151, 220], [75, 75, 76]])
def test_a_follower_that_is_killed_and_goes_on_gives_the_same_estimates(short: Recording, cuts: list[int]) -> None:
    samples = rows(short)
    samples[150:155] = []
    samples[170][1] = math.nan
    without = hillobs.follow(MUSCLES, "sliding_mode", learning=0.6)
    told = stepped(without, samples)
    follower = hillobs.follow(MUSCLES, "sliding_mode", learning=0.6)
    again = []
    for i, sample in enumerate(samples):
        if i in cuts:
            follower = hillobs.follow(MUSCLES, "sliding_mode", state=follower.state())
        again += stepped(follower, [sample])
    assert repr(again) == repr(told)
    assert follower.state() == without.state()


def test_samples_without_times_are_counted_on(short: Recording) -> None:
    values = [values for _, *values in rows(short)]
    without = hillobs.follow(MUSCLES, "high_gain", period=PERIOD, gains=GAINS)
    told = [without.step(*sample) for sample in values]
    follower = hillobs.follow(MUSCLES, "high_gain", period=PERIOD, gains=GAINS)
    again = [follower.step(*sample) for sample in values[:77]]
    follower = hillobs.follow(MUSCLES, "high_gain", state=follower.state())
    assert [*again, *(follower.step(*sample) for sample in values[77:])] == told


@pytest.fixture(scope="module")
def state(short: Recording) -> bytes:
    follower = hillobs.follow(MUSCLES, "high_gain", period=PERIOD, gains=GAINS)
    stepped(follower, rows(short)[:20])
    return follower.state()


def forged(state: bytes, **changes: Any) -> bytes:
    """With a seal that fits: anybody can make one."""
    return sealed(json.dumps({**json.loads(unsealed(state) or b""), **changes}).encode())


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda state: b"", "it is none of hillobs, or it is damaged"),
        (lambda state: state[:-1], "it is none of hillobs, or it is damaged"),
        (lambda state: state.replace(b"0.2", b"0.3"), "it is none of hillobs, or it is damaged"),
        (lambda state: bytearray(state), "it is none of hillobs, or it is damaged"),
        (lambda state: state.decode("latin1"), "it is none of hillobs, or it is damaged"),
        (lambda state: sealed(b"\xff"), "it is none of hillobs"),
        (lambda state: sealed(b"[" * 100_000), "its content cannot be read"),
        (lambda state: sealed(b"{}"), "it is none of this version of hillobs"),
        (lambda state: forged(state, version=2), "it is none of this version of hillobs"),
        (lambda state: forged(state, more=1), "its content has another form"),
        (lambda state: forged(state, x=[math.nan] * 7), "its content has another form"),
        (lambda state: forged(state, count=2**80), "its count has another size"),
        (lambda state: forged(state, x=[0.0] * 6), "its x has another size"),
        (lambda state: forged(state, x=[]), "its x has another size"),
        (lambda state: forged(state, y=[0.0] * 4), "its y has another size"),
        (lambda state: forged(state, last=[]), "its last has another size"),
        (lambda state: forged(state, last=[0.2]), "its times do not belong together"),
        (lambda state: forged(state, base=-1e9), "its times do not belong together"),
        (lambda state: forged(state, start=[0.2]), "its times do not belong together"),
        (lambda state: forged(state, followed=[0.2]), "its times do not belong together"),
        (lambda state: forged(state, start=[1.0, 2.0]), "its start has another size"),
        (lambda state: forged(state, learnt_from=[[1.0]]), "its learnt_from has another size"),
        (
            lambda state: forged(state, learnt_from=[[0.0, -5.0, 1.0, 1.0], [0.095, 0.3, 1.0, 1.0]]),
            "position = -5 m; the mass is between",
        ),
        (
            lambda state: forged(state, learnt_from=[[1.0, 0.3, 1.0, 1.0]] * 2),
            "the times of its samples do not rise from",
        ),
        (lambda state: forged(state, gains={}), "its gains are not those of this observer"),
        (lambda state: forged(state, gains={**GAINS, "high_gain.m": -1.0}), "high_gain.m must be above 0, not -1"),
        (lambda state: forged(state, learning=True), "its gains are not those of this observer"),
        (lambda state: forged(state, period=-1.0), "the period must be at least 1e-06 s, not -1 s"),
        (lambda state: forged(state, T=-1.0), "the period must be at least 1e-06 s, not -0.1 s"),
        (lambda state: forged(state, T=1e-300), "the period must be at least 1e-06 s, not 1e-301 s"),
        (lambda state: forged(state, T=5e-324), "the period must be at least 1e-06 s, not 0 s"),
        (lambda state: forged(state, T=0.0), "the period must be above 0 s, not 0 s"),
        (lambda state: forged(state, T=1e9), "is too few for muscles of v_max = 10/s"),
        (lambda state: forged(state, seconds=1e9), "learning must be above 0 and at most 600 s, not 1e+09 s"),
    ],
)
def test_bytes_of_others_are_refused(state: bytes, change: Callable[[bytes], Any], sentence: str) -> None:
    with pytest.raises(ResultError, match=r"^the state cannot be gone on from: ") as caught:
        hillobs.follow(MUSCLES, "high_gain", state=change(state))
    assert sentence in str(caught.value)
    assert len(str(caught.value)) < 300


def test_a_state_is_that_of_one_observer_of_the_same_muscles(state: bytes) -> None:
    for muscles, observer, corrected in (
        (MUSCLES, "sliding_mode", True),
        (HINGE, "high_gain", True),
    ):
        with pytest.raises(ResultError, match="it is that of another observer or of other muscles"):
            hillobs.follow(muscles, observer, corrected=corrected, state=state)
    with pytest.raises(hillobs.ScenarioError, match="a state knows its gains and its period; leave them out"):
        hillobs.follow(MUSCLES, "high_gain", period=PERIOD, state=state)


NUMBERS = st.floats(allow_nan=False, allow_infinity=False)


@settings(max_examples=30)
@given(st.lists(NUMBERS, min_size=7, max_size=7), st.lists(NUMBERS, min_size=3, max_size=3), NUMBERS, NUMBERS)
def test_whatever_numbers_are_in_a_state_samples_are_followed_or_refused(
    state: bytes, x: list[float], y: list[float], start: float, last: float
) -> None:
    times = {"start": [min(start, last)], "followed": [last], "last": [last], "base": last, "count": 0}
    follower = hillobs.follow(MUSCLES, "high_gain", state=forged(state, x=x, y=y, first=y, **times))
    refusals = []
    for i in range(3):
        try:
            follower.step(0.31, 380.0, 380.0, time=0.2 + i * PERIOD)
        except hillobs.RecordingError as error:
            refusals.append(str(error))
    assert all("time must rise" in refusal for refusal in refusals)
