"""Sample by sample an observer is that of `estimate`, whatever samples are left out; gains are those it would find."""

import json
import math
import re

import numpy as np
import pytest

import hillobs
from double_pole import double_pole
from hillobs import Recording, RecordingError
from hillobs.studies.files.datasets.netcdf import sealed, unsealed
from live_samples import QUANTITIES, assert_same, numbers, rows, stepped
from shipped_recording import CHAINS, HINGE, MUSCLES, part

pytestmark = pytest.mark.numerics


def test_sample_by_sample_the_estimates_are_those_of_the_recording(short: Recording) -> None:
    # a gap of four samples, and one of half a period, as a clock that is not the recording's leaves them
    kept = np.delete(np.arange(len(short)), [100, 101, 102, 103])
    uneven = part(short, kept, time=short.time[kept] + 0.0024 * (np.arange(len(kept)) == 40))
    estimates = hillobs.estimate(uneven, MUSCLES, CHAINS)
    for observer in CHAINS:
        follower = hillobs.follow(MUSCLES, observer, gains=estimates)
        assert not follower.learning
        assert_same(stepped(follower, rows(uneven)), estimates, observer)


def test_so_are_those_of_a_mechanism_however_its_samples_are_given(hinge_short: Recording) -> None:
    estimates = hillobs.estimate(hinge_short, HINGE, ["high_gain", "kalman_constant"])
    position, *forces = hinge_short.measured
    by_name, in_parts = (hillobs.follow(HINGE, "high_gain", gains=estimates) for _ in range(2))
    named = [
        by_name.step(time=time, **{position: q, forces[0]: F1, forces[1]: F2}) for time, q, F1, F2 in rows(hinge_short)
    ]
    parted = [in_parts.step([q], np.array(F), time=time) for time, q, *F in rows(hinge_short)]
    assert_same(named, estimates, "high_gain")
    assert_same(parted, estimates, "high_gain")
    assert list(named[-1].position) == ["elbow"]
    assert list(named[-1].activation) == estimates.muscle.values.tolist()
    follower = hillobs.follow(HINGE, "kalman_constant", gains=estimates)
    assert_same(stepped(follower, rows(hinge_short)), estimates, "kalman_constant")


def test_gains_are_learnt_as_estimate_finds_them(short: Recording) -> None:
    seconds = 0.6
    start = part(short, short.time <= short.time[0] + seconds)
    found = json.loads(hillobs.estimate(start, MUSCLES, "high_gain").attrs["gains"])["high_gain"]
    follower = hillobs.follow(MUSCLES, "high_gain", learning=seconds)
    estimates = stepped(follower, rows(short))
    assert follower.gains == found
    known = hillobs.estimate(short, MUSCLES, "high_gain", changes=found)
    first = len(start) - 1
    assert np.isnan(numbers(estimates[:first], "activation")).all()
    assert_same(estimates[first:], known.isel(time=slice(first, None)), "high_gain")
    # a gain by hand stays, and the others are learnt beside it
    by_hand = hillobs.follow(MUSCLES, "high_gain", learning=seconds, gains={"high_gain.eps_h": 0.3})
    assert by_hand.learning
    stepped(by_hand, rows(start))
    assert by_hand.gains == {**found, "high_gain.eps_h": 0.3}


def test_without_times_samples_are_a_period_apart(short: Recording) -> None:
    gains = {"high_gain.eps_h": 0.2, "high_gain.eps_L": 0.05}
    counted, timed = (hillobs.follow(MUSCLES, "high_gain", period=0.005, gains=gains) for _ in range(2))
    for i, (_, *values) in enumerate(rows(short)):
        # ten samples did not come: the next one says when it is
        time = None if i != 50 else 0.3
        expected = i * 0.005 if i < 50 else 0.3 + (i - 50) * 0.005
        assert counted.step(*values, time=time) == timed.step(*values, time=expected)


def test_a_gap_is_no_estimate_and_then_a_straight_line(short: Recording) -> None:
    missing = [20, 21, 90]
    without = part(short, np.delete(np.arange(len(short)), missing))
    estimates = hillobs.estimate(without, MUSCLES, "high_gain")
    follower = hillobs.follow(MUSCLES, "high_gain", gains=estimates)
    samples = rows(short)
    for i, gap in zip(missing, (math.nan, None, math.nan), strict=True):
        samples[i][2] = gap
    told = stepped(follower, samples)
    for i in missing:
        assert all(np.isnan(numbers(told[i : i + 1], quantity)).all() for quantity in QUANTITIES)
        assert told[i].time == short.time[i]
    assert_same([estimate for i, estimate in enumerate(told) if i not in missing], estimates, "high_gain")


def test_after_a_long_gap_the_observer_begins_anew(short: Recording) -> None:
    gains = {"high_gain.eps_h": 0.2, "high_gain.eps_L": 0.05}
    follower, fresh = (hillobs.follow(MUSCLES, "high_gain", period=0.005, gains=gains) for _ in range(2))
    samples = rows(short)
    stepped(follower, samples[:50])
    later = [[time + 0.11, *values] for time, *values in samples[50:80]]
    again = stepped(follower, later)
    assert again[0].age == 0
    assert repr(again) == repr(stepped(fresh, later))


def test_what_is_wrong_with_a_sample_is_said_and_it_counts_as_not_there(short: Recording) -> None:
    gains = {"high_gain.eps_h": 0.2, "high_gain.eps_L": 0.05}
    disturbed, calm = (hillobs.follow(MUSCLES, "high_gain", period=0.005, gains=gains) for _ in range(2))
    samples = rows(short)
    assert stepped(disturbed, samples[:9]) == stepped(calm, samples[:9])
    good, last = samples[9][1:], samples[8][0]
    for values, time, sentence in (
        ([0.3, 400.0], 0.05, "the sample has 2 numbers; it needs 3: position, force_1, force_2"),
        ([-0.3, 400.0, 400.0], 0.05, "position = -0.3 m; the mass is between 0 and C"),
        ([31.0, 400.0, 400.0], 0.05, "is it in another unit"),
        ([0.3, 4e5, 400.0], 0.05, "force_1 = 400000 N; F_max is"),
        ([0.3, -4e5, 400.0], 0.05, "a tendon only pulls"),
        ([0.3, math.inf, 400.0], 0.05, "force_1 must be a finite number, not inf"),
        (["0.3", 400.0, 400.0], 0.05, "position must be a number, not '0.3'"),
        (good, last, "time must rise from sample to sample: 0.04 s comes after 0.04 s"),
        (good, math.nan, "time must be a finite number, not nan"),
        (good, "now", "time must be a number, not 'now'"),
    ):
        with pytest.raises(RecordingError, match=r".+") as caught:
            disturbed.step(*values, time=time)
        assert sentence in str(caught.value)
        assert "\n" not in str(caught.value)
    for columns, sentence in (
        ({"position": 0.3, "force_1": 400.0}, "the sample has no force_2; it needs position, force_1, force_2"),
        ({"position": 0.3, "force_1": 1.0, "force_2": 1.0, "force_3": 1.0}, "'force_3' is nothing that a sample has"),
    ):
        with pytest.raises(RecordingError, match=sentence):
            disturbed.step(**columns)
    with pytest.raises(RecordingError, match="by place or by name"):
        disturbed.step(0.3, force_1=1.0, force_2=1.0)
    assert repr(stepped(disturbed, samples[9:30])) == repr(stepped(calm, samples[9:30]))


def test_an_observer_that_fails_says_when_and_has_no_estimates_from_then_on(short: Recording) -> None:
    gains = {"high_gain.eps_h": 0.2, "high_gain.eps_L": 0.05}
    follower = hillobs.follow(MUSCLES, "high_gain", period=0.005, gains=gains)
    samples = rows(short)
    stepped(follower, samples[:5])
    # no recording of a muscle does it: a state beyond all limits
    content = json.loads(unsealed(follower.state()) or b"")
    wild = sealed(json.dumps({**content, "x": [1e9] * len(content["x"])}).encode())
    follower = hillobs.follow(MUSCLES, "high_gain", state=wild)
    told = stepped(follower, samples[5:9])
    assert all(math.isnan(estimate.position) for estimate in told)
    assert re.fullmatch(r"high_gain: x1_hat is not a number within ±\S+ at 0.025 s; .*", follower.failure)
    # another follower goes on from there, as one that has failed
    again = hillobs.follow(MUSCLES, "high_gain", state=follower.state())
    assert again.failure == follower.failure
    assert math.isnan(stepped(again, samples[9:10])[0].position)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"observer": "nobody"}, "unknown observer 'nobody'; there are high_gain"),
        ({"observer": 3}, "an observer is a name or a Block, not 3"),
        ({"muscles": 3}, "muscles are a file's name or a pair that was read, not 3"),
        ({"period": 0.0}, "period must be above 0 s, not 0 s"),
        ({"period": -1.0}, "period must be above 0 s, not -1 s"),
        ({"period": "5ms"}, "period must be a number, not '5ms'"),
        ({"period": 0.5}, "a sample every 0.5 s is too few for muscles of v_max = 10/s; at most 0.07 s"),
        ({"period": 1e-9}, "the period must be at least 1e-06 s, not 1e-09 s"),
        ({"learning": 0}, "learning must be above 0 and at most 600 s, not 0 s"),
        ({"gains": {"high_gain.eps_h": 0.1, "high_gain.eps_L": 0.1}}, "period, in s from sample to sample, must be"),
        ({"gains": {"eps_h": 0.1}}, "'eps_h' is no gain of high_gain"),
        ({"gains": {"high_gain.eps_h": 0.0}}, "high_gain.eps_h must be above 0, not 0"),
        ({"gains": 3}, "gains must be a dict, not 3"),
        ({"gains": np.array([1.0, 2.0])}, "gains must be a dict, not [1. 2.]"),
        (
            {"gains": {"high_gain.eps_h": 1e-5, "high_gain.eps_L": 0.1}, "period": 0.005},
            "the gains of high_gain are too fast for samples τ = 0.05 apart",
        ),
        ({"corrected": "yes"}, "corrected must be true or false, not 'yes'"),
    ],
)
def test_wrong_arguments_are_sentences(arguments: dict[str, object], sentence: str) -> None:
    with pytest.raises(hillobs.Error) as caught:
        hillobs.follow(**{"muscles": MUSCLES, "observer": "high_gain", **arguments})
    assert str(caught.value).startswith(sentence)


def test_nothing_is_learnt_from_samples_that_are_too_rare() -> None:
    follower = hillobs.follow(MUSCLES, "high_gain", learning=0.3)
    values = 0.31, 400.0, 400.0
    for start in (0.0, 1.0):
        for i in range(3):
            follower.step(*values, time=start + i * 0.1)
        with pytest.raises(
            RecordingError, match=r"nothing can be learnt: a sample every 0\.1 s is too few for muscles"
        ):
            follower.step(*values, time=start + 0.31)
    # it begins with the sample after that
    assert follower.learning
    assert follower.step(*values, time=1.4).age == 0


def test_an_observer_of_your_own_follows_with_its_own_numbers(short: Recording) -> None:
    mine = double_pole(name="mine")
    # no rule knows its numbers, so nothing is learnt; a triple pole of 200/τ asks for five steps
    given = hillobs.follow(MUSCLES, mine, period=0.005, gains={"mine.rate": 200.0})
    assert not given.learning
    assert_same(stepped(given, rows(short)), hillobs.estimate(short, MUSCLES, mine, changes=given.gains), "mine")


def test_samples_need_times_where_no_period_is_given() -> None:
    follower = hillobs.follow(MUSCLES, "high_gain")
    with pytest.raises(RecordingError, match="the sample needs its time, since no period is given"):
        follower.step(0.31, 400.0, 400.0)


def test_estimates_of_other_observers_have_no_gains_for_this_one(short: Recording) -> None:
    estimates = hillobs.estimate(short, MUSCLES, "high_gain")
    with pytest.raises(hillobs.ScenarioError, match="those of high_gain, and have no gains of sliding_mode"):
        hillobs.follow(MUSCLES, "sliding_mode", gains=estimates)
    with pytest.raises(hillobs.ScenarioError, match="those of no observer, and have no gains of high_gain"):
        hillobs.follow(MUSCLES, "high_gain", gains=estimates.assign_attrs(gains="{}"))
