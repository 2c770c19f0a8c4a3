"""What a recording lacks is bridged and told, or refused in one sentence; no recording gives anything else."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from hillobs.studies.cli.reports.estimates.estimate import failures, notes
from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.scores import scores
from hillobs.studies.files.errors import RecordingError
from hillobs.studies.laboratory.muscles import MusclePair, read_muscles
from hillobs.studies.laboratory.recording import Recording, read_recording
from shipped_recording import ALL_OBSERVERS, MUSCLES, SHIPPED, part, rmse

pytestmark = pytest.mark.numerics


def test_short_gaps_are_bridged_and_told(short: Recording) -> None:
    force = short["force_1"].copy()
    force[100:110] = np.nan
    estimates = estimate(short.remeasured(force_1=force), MUSCLES, ALL_OBSERVERS)
    assert np.flatnonzero(estimates.bridged).tolist() == list(range(100, 110))
    np.testing.assert_allclose(
        estimates.force[100:110, 0], np.interp(np.arange(10), [-1, 10], short["force_1"][[99, 110]])
    )
    told = list(notes(estimates))
    assert "gaps bridged by straight lines from 0.5 to 0.545 s" in told
    assert "force_1 has no value in 10 of 300 rows: 102–111" in told
    # the bridge is what a straight line would have been, but for the filter that knows that nothing was measured
    straight = short.remeasured(force_1=estimates.force[:, 0].values)
    as_measured = estimate(straight, MUSCLES, ALL_OBSERVERS)
    others = [name for name in ALL_OBSERVERS if name != "kalman"]
    np.testing.assert_array_equal(
        as_measured.activation_hat.sel(observer=others), estimates.activation_hat.sel(observer=others)
    )
    during = {"observer": "kalman", "time": slice(0.51, 0.54)}
    assert (estimates.activation_sd_state.sel(during) > 1.1 * as_measured.activation_sd_state.sel(during)).all()


def test_gains_and_noise_are_those_of_the_recording_where_a_quarter_of_its_samples_is_missing(
    noisy: xr.Dataset,
) -> None:
    whole = read_recording(SHIPPED)
    kept = np.random.default_rng(3).random(len(whole)) > 0.25
    true = {name: values[kept] for name, values in whole.true.items()}
    estimates = estimate(part(whole, kept, true=true), MUSCLES, ["high_gain", "kalman"])
    sizes, usual = (json.loads(of.attrs["sizes"]) for of in (estimates, noisy))
    # a median of 360 differences is off by 1.2/√360 = 6 %
    for kind, names in (("joints", ("sigma", "eps", "D")), ("muscles", ("sigma_F", "eps_2", "U"))):
        for of, expected in usual[kind].items():
            for name in names:
                assert sizes[kind][of][name] == pytest.approx(expected[name], rel=0.15), (of, name)
    for quantity in ("velocity", "activation"):
        errors, all_of_it = rmse(estimates, quantity), rmse(noisy, quantity)
        for name, error in errors.items():
            # of 3/4 of the samples it is larger by √(4/3)
            assert error < 1.25 * all_of_it[name], (name, quantity)


@pytest.mark.parametrize(
    ("name", "places", "sentence"),
    [
        ("position", slice(50, 90), "position has no value in rows 52 to 91, 0.205 s; gaps of up to 0.1 s are bridged"),
        ("force_2", slice(0, 2), "force_2 has no value in row 2, an end of the recording"),
        ("force_1", slice(298, 300), "force_1 has no value in row 301, an end of the recording"),
        ("position", slice(None), "position has no value in row 2, an end of the recording"),
    ],
)
def test_gaps_that_nobody_can_bridge_are_refused(name: str, places: slice, sentence: str, short: Recording) -> None:
    values = short[name].copy()
    values[places] = np.nan
    assert refusal(short.remeasured(**{name: values})) == sentence


def refusal(recording: Recording, muscles: str | Path | MusclePair = MUSCLES) -> str:
    with pytest.raises(RecordingError) as caught:
        estimate(recording, muscles, "high_gain")
    return str(caught.value).removeprefix(f"{recording.source}: ")


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("force_1", -200.0, "row 12: force_1 = -200 N; a tendon only pulls, so forces are positive"),
        ("force_2", 2e4, "row 12: force_2 = 20000 N; F_max is 1000 N; is it in another unit?"),
        ("position", 310.0, "row 12: position = 310 m; the mass is between 0 and C = 0.62 m; is it in another unit?"),
        ("position", -0.1, "row 12: position = -0.1 m; the mass is between 0 and C = 0.62 m"),
    ],
)
def test_what_no_muscle_can_do_is_refused(name: str, value: float, sentence: str, short: Recording) -> None:
    values = short[name].copy()
    values[10:] = value
    assert refusal(short.remeasured(**{name: values})) == sentence


def test_missing_rows_and_slow_sampling_are_refused(short: Recording) -> None:
    rows = np.r_[0:100, 130:300]
    sentence = "there is no sample between rows 101 and 132, 0.155 s; gaps of up to 0.1 s are bridged"
    assert refusal(part(short, rows)) == sentence
    slow = dataclasses.replace(short, time=short.time * 20)
    assert (
        refusal(slow)
        == "a sample every 0.1 s is too few for muscles of v_max = 10/s; at most 0.07 s; is time in another unit?"
    )
    # slower muscles, rarer samples
    pair = read_muscles(MUSCLES)
    muscle = dataclasses.replace(pair.muscle1, v_max=0.5)
    estimates = estimate(slow, dataclasses.replace(pair, muscle1=muscle, muscle2=muscle, mass=8000.0), ALL_OBSERVERS)
    assert np.isfinite(estimates.activation_hat).all()


def test_one_row_is_too_few_and_two_will_do(short: Recording) -> None:
    assert refusal(part(short, slice(0, 1))) == "has one row of numbers; observers need two or more"
    for n in (2, 3, 49, 50, 51):
        # densities are found in 50 samples or more
        observers = [name for name in ALL_OBSERVERS if name != "kalman" or n >= 50]
        estimates = estimate(part(short, slice(0, n)), MUSCLES, observers)
        assert estimates.sizes == {"observer": len(observers), "time": n, "muscle": 2}
        assert np.isfinite(estimates.activation_hat).all()
        assert not scores(estimates)
        assert len(list(notes(estimates))) >= 5


def test_slack_and_limits_are_told(short: Recording) -> None:
    force = short["force_2"].copy()
    force[120:160] = -0.5
    estimates = estimate(short.remeasured(force_2=force), MUSCLES, "high_gain")
    assert np.flatnonzero(estimates.slack.sel(muscle=2)).tolist() == list(range(120, 160))
    assert not estimates.slack.sel(muscle=1).any()
    told = "\n".join(notes(estimates))
    assert "tendon 2 carries no force from 0.6 to 0.795 s" in told
    assert "activation 2 would be below 0 or above 1" in told
    assert ((estimates.activation_hat >= 0) & (estimates.activation_hat <= 1)).all()


@pytest.mark.parametrize("mirrored", [False, True])
def test_muscles_that_are_swapped_are_suspected(noisy: xr.Dataset, mirrored: bool) -> None:
    told = "accelerates against the difference of the tendon forces"
    assert told not in "\n".join(notes(noisy))
    whole = read_recording(SHIPPED)
    swapped = {"force_1": whole["force_2"], "force_2": whole["force_1"]}
    wrong = whole.remeasured(**({"position": 0.62 - whole["position"]} if mirrored else swapped))
    assert told in "\n".join(notes(estimate(wrong, MUSCLES, "high_gain")))


numbers = st.floats(allow_nan=False, allow_infinity=False, width=64)


@settings(max_examples=60)
@given(
    st.lists(
        st.tuples(
            st.one_of(st.just(0.005), st.floats(1e-9, 0.2)),
            st.one_of(st.floats(0, 0.62), st.just(float("nan")), numbers),
            st.one_of(st.floats(0, 2000), st.floats(-200, 1e4), st.just(float("nan")), numbers),
            st.floats(-150, 10_000),
        ),
        min_size=1,
        max_size=60,
    )
)
def test_whatever_was_recorded_there_is_a_result_or_one_sentence(
    rows: list[tuple[float, float, float, float]],
) -> None:
    steps, position, force_1, force_2 = np.array(rows).T
    measured = {"position": position, "force_1": force_1, "force_2": force_2}
    recording = Recording("any.csv", np.cumsum(steps), measured, {}, np.arange(len(rows)) + 2)
    told = ""
    try:
        estimates = estimate(recording, MUSCLES, ALL_OBSERVERS)
        assert len(list(notes(estimates))) >= 5
        a = estimates.activation_hat.values
        assert (np.isnan(a) | ((a >= 0) & (a <= 1))).all()
        assert np.isnan(a).any() <= bool(list(failures(estimates)))
    except RecordingError as error:
        told = str(error)
    assert not told or told.startswith("any.csv: ")
    assert "\n" not in told
