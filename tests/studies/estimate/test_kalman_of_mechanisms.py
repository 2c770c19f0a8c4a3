"""The Kalman filter of joints and muscles: as accurate as promised, as sure as it says, with numbers by hand."""

import dataclasses
import functools
import json

import numpy as np
import pytest
import xarray as xr

from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.schema import arguments
from hillobs.studies.estimate.scores import SETTLED
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.laboratory.subject import subject_of
from places import DATA, RECORDINGS
from random_recordings import as_mechanism, drawn
from shipped_recording import DYNAMOMETER, HINGE, part

pytestmark = pytest.mark.numerics

ARM = RECORDINGS / "arm.toml"
# RMSE of activations by filter and smoother, of the smoother's angular velocity in rad/s (the slider's in m/s)
CASES = {"hinge_pair_noisy.csv.gz": (HINGE, 0.0045, 0.0018, 0.0031)}
OTHERS = {
    "dynamometer_noisy.csv.gz": (DYNAMOMETER, 0.0124, 0.0034, 0.0009),
    "arm_noisy.csv.gz": (ARM, 0.0047, 0.0018, 0.0041),
    "arm_smooth_noisy.csv.gz": (ARM, 0.0047, 0.0019, 0.0034),
}
NAMES = pytest.mark.parametrize(
    "name",
    [*CASES, *(pytest.param(name, marks=[pytest.mark.chaos, pytest.mark.xdist_group("arm")]) for name in OTHERS)],
)
QUANTITIES = ("position", "velocity", "disturbance", "tendon_length", "fibre_length", "fibre_velocity", "activation")
# a slider as light as the joints of no arm, between tendons so stiff that forces smoothed by way of it are off
LIGHT = 1000
MANY = range(1000, 1012)


@functools.cache
def followed(name: str, smooth: bool = False, lag: float = 0.0) -> xr.Dataset:
    """After a second."""
    folder = RECORDINGS if (RECORDINGS / name).exists() else DATA
    mechanism, *_ = {**CASES, **OTHERS}[name]
    estimates = estimate(folder / name, mechanism, "kalman", smooth=smooth, lag=lag, usual_doubt=False)
    return estimates.sel(observer="kalman", time=slice(SETTLED, None))


def rmse(of: xr.Dataset, name: str) -> float:
    return float(np.sqrt(((of[f"{name}_hat"] - of[f"true_{name}"]) ** 2).mean()))


def covered(of: xr.Dataset, name: str) -> float:
    """By the band of 95 %."""
    return float((abs(of[f"{name}_hat"] - of[f"true_{name}"]) < 1.96 * of[f"{name}_sd"]).mean())


def known(of: xr.Dataset) -> list[str]:
    """The force that moves a prescribed joint is not known."""
    return [name for name in QUANTITIES if not of[f"{name}_hat"].isnull().all() and f"true_{name}" in of]


@NAMES
def test_one_rule_for_all_is_as_good_as_promised(name: str) -> None:
    _, filter_, smoother, velocity = {**CASES, **OTHERS}[name]
    causal, smoothed, late = followed(name), followed(name, smooth=True), followed(name, lag=0.05)
    assert rmse(causal, "activation") < filter_
    assert rmse(smoothed, "activation") < smoother
    assert rmse(smoothed, "velocity") < velocity
    for quantity in known(causal):
        assert rmse(smoothed, quantity) < rmse(late, quantity) < rmse(causal, quantity), quantity


@pytest.mark.parametrize("lag", [None, 0.0, 0.02], ids=["smoother", "filter", "lag"])
@NAMES
def test_95_percent_of_the_errors_are_within_1_96_standard_deviations(name: str, lag: float | None) -> None:
    of = followed(name, smooth=lag is None, lag=lag or 0.0)
    for quantity in known(of):
        # inputs are smoother than any chain, and errors of a smoother so slow that 9 s have few of them
        smooth = lag is None or "velocity" in quantity or quantity == "disturbance"
        assert 0.9 < covered(of, quantity) < (1.001 if smooth else 0.99), quantity


def test_without_noise_it_knows_everything() -> None:
    recording, mechanism = as_mechanism(drawn(LIGHT, 3.0, (1000.0,)))
    true = {name: recording.true[name] for name in recording.measured if name in recording.true}
    of = estimate(recording.remeasured(**true), mechanism, "kalman").sel(observer="kalman", time=slice(SETTLED, None))
    assert rmse(of, "activation") < 5e-5
    assert rmse(of, "velocity") < 1e-4


def test_light_links_between_stiff_tendons_are_smoothed_as_surely_as_it_says() -> None:
    recording, mechanism = as_mechanism(drawn(LIGHT, 4.0, (100.0,)))
    for form in ("u", "a"):
        causal, smoothed = (
            estimate(recording, mechanism, "kalman", form=form, smooth=smooth, usual_doubt=False).sel(
                observer="kalman", time=slice(SETTLED, None)
            )
            for smooth in (False, True)
        )
        for name in ("velocity", "activation"):
            assert rmse(smoothed, name) < rmse(causal, name)
            assert covered(smoothed, name) > 0.85


@pytest.mark.chaos
@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
def test_bands_of_drawn_recordings_hold(smooth: bool, record_property) -> None:
    shares: dict[str, list[float]] = {}
    for seed in MANY:
        recording, mechanism = as_mechanism(drawn(seed, rates=(100.0, 200.0)))
        of = estimate(recording, mechanism, "kalman", smooth=smooth, usual_doubt=False).sel(
            observer="kalman", time=slice(SETTLED, None)
        )
        for name in ("activation", "velocity", "fibre_velocity"):
            shares.setdefault(name, []).append(covered(of, name))
    for name, found in shares.items():
        record_property(f"{name}: covered in 10, 50, 90 %", np.percentile(found, [10, 50, 90]).tolist())
        # what the joints are off by is counted in full, and light links are known to be slower than that
        assert 0.92 < np.median(found) < 0.995
        assert np.mean(np.array(found) > 0.85) > 0.8


def hinge(samples: int = 400) -> Recording:
    return part(read_recording(DATA / "hinge_pair_noisy.csv.gz", known=subject_of(HINGE).columns), slice(0, samples))


def test_numbers_by_hand_stay_and_a_result_can_be_repeated() -> None:
    by_hand = {"kalman.elbow.s_D": 0.01, "kalman.BRA.order_u": 1, "kalman.BRA.sigma_F1": 0.009, "kalman.start_u": 0.5}
    found = estimate(hinge(), HINGE, "kalman", changes=by_hand, form="u", lag=0.02)
    gains = json.loads(found.attrs["gains"])["kalman"]
    assert {path: gains[path] for path in by_hand if path in gains} == {
        path: value for path, value in by_hand.items() if "start" not in path
    }
    assert gains["kalman.TRIlat.sigma_F1"] != 0.009
    chains = json.loads(found.attrs["fits"])["kalman"]["chains"]
    assert list(chains) == ["elbow", "TRIlat", "BRA"]
    assert list(chains["BRA"]["u"]["tried"]) == ["1"]
    assert list(chains["TRIlat"]["u"]["tried"]) == ["2", "1", "3"]
    asked = arguments(found)
    del asked["mapping"]
    again = estimate(hinge(), **asked)
    for name in found.data_vars:
        np.testing.assert_array_equal(again[name], found[name])


def test_keeping_every_third_estimate_changes_none() -> None:
    every, third = (estimate(hinge(), HINGE, "kalman", smooth=True, keep_every=n) for n in (1, 3))
    for name in ("activation_hat", "velocity_hat", "activation_sd"):
        np.testing.assert_array_equal(third[name], every[name][:, ::3])


def test_each_muscle_has_the_form_that_is_likelier_unless_one_is_asked_for() -> None:
    of = {form: estimate(hinge(), HINGE, "kalman", form=form) for form in ("auto", "u", "a")}
    chains = {form: json.loads(data.attrs["fits"])["kalman"]["chains"] for form, data in of.items()}
    for j, muscle in enumerate(("TRIlat", "BRA")):
        fit = chains["auto"][muscle]
        likelier = "a" if fit["a"]["log_likelihood"] > fit["u"]["log_likelihood"] else "u"
        assert fit["form"] == likelier
        for name in ("activation_hat", "tendon_length_hat", "activation_sd"):
            np.testing.assert_array_equal(of["auto"][name][..., j], of[likelier][name][..., j])
    assert "a" not in chains["u"]["BRA"]
    # what no muscle has a part in is the same
    np.testing.assert_array_equal(of["u"].velocity_hat, of["a"].velocity_hat)


def test_a_slack_tendon_has_no_band_and_leaves_the_others_theirs() -> None:
    recording = hinge()
    slack = (recording.time >= 0.5) & (recording.time < 0.7)
    changed = recording.remeasured(force_BRA=np.where(slack, 0.0, recording["force_BRA"]))
    of = estimate(changed, HINGE, "kalman").sel(observer="kalman")
    for name in QUANTITIES:
        assert np.isfinite(of[f"{name}_hat"]).all()
    assert of.activation_sd.sel(muscle="BRA")[slack].isnull().all()
    assert of.activation_sd.sel(muscle="TRIlat")[slack].notnull().all()


def test_progress_rises_to_its_end() -> None:
    told: list[float] = []
    estimate(hinge(), HINGE, "kalman", progress=told.append, smooth=True)
    assert told == sorted(told)
    assert told[-1] == pytest.approx(1.0)
    # joint and muscles, twice
    assert len(set(told)) > 5


def test_where_samples_are_missing_it_is_less_sure() -> None:
    recording, first, last = hinge(), 150, 168
    present = np.r_[0:first, last : len(recording)]
    gone = dataclasses.replace(
        part(recording, present), measured={name: values[present] for name, values in recording.measured.items()}
    )
    of = estimate(gone, HINGE, "kalman", form="u").sel(observer="kalman")
    for name in ("position", "velocity", "fibre_length"):
        deviation = of[f"{name}_sd_state"].values
        assert (deviation[first] > 1.1 * deviation[first - 1]).all(), name
