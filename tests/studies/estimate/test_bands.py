"""The band of the muscle's numbers: what a wrong number does to estimates, and that the truth is within it."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm, qmc

from hillobs.model.curves import CURVES
from hillobs.studies.cli.reports.estimates.estimate import notes
from hillobs.studies.cli.reports.estimates.estimate_page import estimate_page
from hillobs.studies.estimate.bands.doubt import USUAL
from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.scores import SETTLED, WITHIN_95
from hillobs.studies.laboratory.muscles import SIZES, Muscle, MusclePair, numbers_of, read_muscles
from hillobs.studies.laboratory.recording import Recording, read_recording
from shipped_recording import MUSCLES, SHIPPED, part

pytestmark = pytest.mark.numerics

OF_A_MUSCLE = ("tendon_length", "fibre_length", "fibre_velocity", "activation")
# the usual ones that the shipped muscles have
DOUBTED = [name for name in USUAL if name in {*SIZES, *numbers_of(CURVES["degroote_fregly2016"])}]
# its gains are those of the recording, whatever the muscles; the likelihood of a filter's asks for the muscles too
LINEAR = "high_gain_3"
# half of it to either side: what a central difference leaves is of the order of its square
STEP = 1e-3


def changed(muscle: Muscle, factors: dict[str, float]) -> Muscle:
    numbers = {name: value * factors.get(name, 1.0) for name, value in muscle.numbers.items()}
    sizes = {name: getattr(muscle, name) * factors.get(name, 1.0) for name in SIZES}
    return dataclasses.replace(muscle, **sizes, numbers=numbers)


def both(pair: MusclePair, factors: dict[str, float]) -> MusclePair:
    muscles = {name: changed(getattr(pair, name), factors) for name in ("muscle1", "muscle2")}
    return dataclasses.replace(pair, **muscles)


def settled(dataset: xr.Dataset, suffix: str) -> xr.Dataset:
    names = [name for name in dataset if str(name).endswith(suffix)]
    return dataset[names].sel(observer=LINEAR, time=slice(SETTLED, None))


def moved(recording: Recording, below: MusclePair, above: MusclePair) -> xr.Dataset:
    """What the estimates move by from one pair to the other."""
    before, after = (settled(estimate(recording, pair, LINEAR, usual_doubt=False), "_hat") for pair in (below, above))
    return after - before


def band(recording: Recording, pair: MusclePair, doubt: dict[str, float | str]) -> xr.Dataset:
    """The part of these numbers alone."""
    return settled(estimate(recording, pair, LINEAR, doubt=doubt, usual_doubt=False), "_sd_muscle")


def disagreement(moves: xr.DataArray, found: xr.DataArray) -> float:
    """Of the sizes of both, as a part of what moves."""
    return float(np.sqrt(((abs(moves) - found) ** 2).mean() / (moves**2).mean()))


@pytest.mark.parametrize("number", [*SIZES, *numbers_of(CURVES["thelen2003"])])
def test_a_changed_number_moves_the_estimates_of_a_clean_recording_by_its_band(
    number: str, unlike: tuple[Path, Path]
) -> None:
    """Two unlike muscles, two curve sets: as far as a difference tells a derivative and û follows: 10⁻³.

    But for Thelen's tendon, whose stiffness has a corner: the filter's estimates are there a sample apart.
    """
    recording, pair = read_recording(unlike[0]), read_muscles(unlike[1])
    damped = dataclasses.replace(pair.muscle1, numbers={**pair.muscle1.numbers, "damping": 0.1})
    pair = dataclasses.replace(pair, muscle1=damped)
    moves = moved(recording, *(both(pair, {number: 1 + sign * STEP / 2}) for sign in (-1, 1)))
    found = band(recording, pair, {number: f"{100 * STEP!r}%"})
    # what moves less is rounding
    least = {"tendon_length": 1e-11, "fibre_length": 1e-11, "fibre_velocity": 1e-9, "activation": 1e-9}
    told = set()
    for name in OF_A_MUSCLE:
        for j in (1, 2):
            move = moves[f"{name}_hat"].sel(muscle=j)
            if float(abs(move).max()) < least[name]:
                continue
            told.add((name, j))
            corner = j == 2 and (number, name) in {("F_max", "fibre_velocity"), ("tendon_strain", "activation")}
            tolerance = 0.02 if corner else 1e-3
            assert disagreement(move, found[f"{name}_sd_muscle"].sel(muscle=j)) < tolerance, (name, j)
    assert ("activation", 2) in told


@pytest.mark.parametrize("number", DOUBTED)
def test_a_changed_number_moves_the_activations_of_a_noisy_recording_by_its_band(number: str) -> None:
    """Noise of û is in the rate of the tendon's length, which is nearly all that the strain of the tendon acts by."""
    recording, pair = read_recording(SHIPPED), read_muscles(MUSCLES)
    moves = moved(recording, *(both(pair, {number: 1 + sign * STEP / 2}) for sign in (-1, 1)))
    found = band(recording, pair, {number: f"{100 * STEP!r}%"})
    tolerance = 0.09 if number == "tendon_strain" else 0.02
    assert disagreement(moves.activation_hat, found.activation_sd_muscle) < tolerance


@pytest.mark.parametrize(
    ("doubt", "column", "offset"),
    [
        ("muscle1.force_bias", "force_1", 1.0),
        ("muscle2.force_bias", "force_2", 1.0),
        ("position_bias", "position", 1e-5),
    ],
)
def test_an_offset_of_a_sensor_moves_the_estimates_by_its_band(
    doubt: str, column: str, offset: float, unlike: tuple[Path, Path]
) -> None:
    recording, pair = read_recording(unlike[0]), read_muscles(unlike[1])
    wrong = [recording.remeasured(**{column: recording[column] + sign * offset / 2}) for sign in (-1, 1)]
    before, after = (settled(estimate(one, pair, LINEAR, usual_doubt=False), "_hat") for one in wrong)
    found = band(recording, pair, {doubt: offset})
    assert {"position_bias": "position_sd_muscle"}.get(doubt, "disturbance_sd_muscle") in found
    for name in found:
        moves = (after - before)[str(name).replace("_sd_muscle", "_hat")]
        # the rate of ∂L_S/∂F jumps at the corner of Thelen's tendon, where estimates are smooth
        assert disagreement(moves, found[name]) < (0.1 if name == "fibre_velocity_sd_muscle" else 2e-3), name


def test_the_mass_and_the_distance_of_the_origins_may_be_in_doubt(unlike: tuple[Path, Path]) -> None:
    recording, pair = read_recording(unlike[0]), read_muscles(unlike[1])
    for number, moves_what in (("mass", "disturbance"), ("C", "activation")):
        value = getattr(pair, number)
        others = [dataclasses.replace(pair, **{number: value * (1 + sign * STEP / 2)}) for sign in (-1, 1)]
        moves = moved(recording, *others)[f"{moves_what}_hat"]
        found = band(recording, pair, {number: STEP * value})[f"{moves_what}_sd_muscle"]
        # the estimated acceleration lags, by 3 ε of the position's chain
        assert disagreement(moves, found) < (0.1 if number == "mass" else 1e-3)
        if number == "C":
            assert not found.sel(muscle=1).any()


def test_where_numbers_are_wrong_at_random_the_truth_is_within_the_band() -> None:
    """Nominal 95 %. An error is common to a whole recording, so the mean over draws counts; in strata few will do.

    Noise alone is a seventh of the error of 0.07: within 1.96 · 0.14 of a normal distribution are 22 %, and more where
    the numbers matter less.
    """
    whole = read_recording(SHIPPED)
    first = slice(0, int((whole.time < 3).sum()))
    recording = part(whole, first, true={name: values[first] for name, values in whole.true.items()})
    pair = read_muscles(MUSCLES)
    draws = norm.ppf(qmc.LatinHypercube(2 * len(DOUBTED), rng=np.random.default_rng(1)).random(16))
    covered: dict[str, list[float]] = {"_sd": [], "_sd_state": []}
    for draw in draws:
        factors = [
            {name: 1 + USUAL[name].default * z for name, z in zip(DOUBTED, half, strict=True)}
            for half in np.split(draw, 2)
        ]
        wrong = dataclasses.replace(
            pair, muscle1=changed(pair.muscle1, factors[0]), muscle2=changed(pair.muscle2, factors[1])
        )
        of = estimate(recording, wrong, "kalman", form="u").sel(observer="kalman", time=slice(SETTLED, None))
        error = abs(of.activation_hat - of.true_activation)
        for suffix, shares in covered.items():
            shares.append(float((error < WITHIN_95 * of[f"activation{suffix}"]).mean()))
    assert 0.92 < np.mean(covered["_sd"]) < 0.97
    assert np.mean(covered["_sd_state"]) < 0.3


def test_the_band_is_the_part_of_noise_and_that_of_the_numbers(noisy: xr.Dataset) -> None:
    of = noisy.sel(observer="kalman")
    for name in OF_A_MUSCLE:
        whole, state, muscle = (of[f"{name}_sd{part}"] for part in ("", "_state", "_muscle"))
        np.testing.assert_allclose(whole**2, state**2 + muscle**2, rtol=1e-12)
        assert whole.attrs["units"] == state.attrs["units"] == muscle.attrs["units"] == of[f"{name}_hat"].attrs["units"]
    for name in ("position", "velocity", "disturbance"):
        # no number of a muscle is in them
        assert f"{name}_sd_muscle" not in noisy
        np.testing.assert_allclose(of[f"{name}_sd"], of[f"{name}_sd_state"], rtol=1e-12)
    # what an observer without covariance cannot know
    other = noisy.sel(observer="high_gain")
    assert np.isnan(other.activation_sd).all()
    np.testing.assert_allclose(other.activation_sd_muscle.mean(), of.activation_sd_muscle.mean(), rtol=0.05)


def test_a_sentence_tells_what_the_numbers_may_do_to_the_activations(noisy: xr.Dataset, short: Recording) -> None:
    (told,) = (sentence for sentence in notes(noisy) if "95 %" in sentence)
    # that of the observer whose noise is known too, whichever comes first
    assert told.startswith(
        "the activations of KF may be off by 0.084 (95 %, median over time) since the muscles' numbers"
    )
    alone = " ".join(notes(noisy.sel(observer=["high_gain"])))
    assert "the activations of HGO may be off by 0.08" in alone
    for sure in (
        estimate(short, MUSCLES, usual_doubt=False),
        estimate(short, MUSCLES, doubt={"mass": "1%"}, usual_doubt=False),
    ):
        assert "95 %" not in " ".join(notes(sure))
    # a few samples without a slope are not all; where most are so, nothing is known
    wild = noisy.activation_sd_muscle.copy()
    wild[:, :50] = 1e20
    assert [s for s in notes(noisy.assign(activation_sd_muscle=wild)) if "activations of KF may be off by 0.08" in s]
    (none,) = (s for s in notes(noisy.assign(activation_sd_muscle=wild * 0 + 1e20)) if "may be off" in s)
    assert none.startswith("how far the activations of KF may be off cannot be told")


def test_a_sentence_and_the_report_list_the_deviations_in_force_with_their_units(short: Recording) -> None:
    doubt = {"F_max": 0.05, "muscle1.v_max": "20%", "force_bias": "5N", "position_bias": "0.1mm", "mass": "2%"}
    estimates = estimate(short, MUSCLES, ["high_gain"], doubt=doubt)
    (told,) = (sentence for sentence in notes(estimates) if "standard deviations:" in sentence)
    assert told.strip().split(": ")[1].split(", ") == [
        "F_max 0.05 N", "optimal_fibre_length 0.003 m", "tendon_slack_length 0.002 m", "muscle1.v_max 2 1/s",
        "tendon_strain 0.0049", "passive_strain 0.03", "force_bias 5 N", "muscle2.v_max 1 1/s", "mass 0.4 kg",
        "position_bias 0.0001 m",
    ]  # fmt: skip
    page = estimate_page(estimates, [], [], b"").decode()
    for cell in ("0.05 N", "muscle1.v_max", "2 1/s", "0.0001 m"):
        assert f">{cell}<" in page
    sure = estimate(short, MUSCLES, ["high_gain"], usual_doubt=False)
    assert (
        "standard deviations" not in " ".join(notes(sure)).lower() + estimate_page(sure, [], [], b"").decode().lower()
    )


def test_without_doubt_noise_is_all(short: Recording) -> None:
    plain = estimate(short, MUSCLES, ["kalman", "high_gain"], usual_doubt=False)
    assert not [name for name in plain if str(name).endswith("_sd_muscle")]
    xr.testing.assert_equal(plain.activation_sd, plain.activation_sd_state)
    assert json.loads(plain.attrs["doubt"]) == {}
    usual = estimate(short, MUSCLES, ["kalman", "high_gain"])
    xr.testing.assert_equal(plain.activation_sd_state, usual.activation_sd_state)


def test_the_band_is_that_of_the_sample_whatever_else_is_kept(short: Recording) -> None:
    rare, every = (estimate(short, MUSCLES, "kalman", keep_every=keep) for keep in (7, 1))
    for name in ("activation_sd", "fibre_velocity_sd_muscle"):
        np.testing.assert_array_equal(rare[name], every[name][:, ::7])


def test_a_slack_tendon_has_no_band_until_its_force_has_passed_the_noise(short: Recording) -> None:
    force = short["force_2"].copy()
    force[120:160] = -0.5
    # above 0 and below five times the noise of some 5 N
    force[160:170] = 4.0
    of = estimate(short.remeasured(force_2=force), MUSCLES, "kalman").sel(observer="kalman")
    for name in OF_A_MUSCLE:
        for suffix in ("_sd", "_sd_state", "_sd_muscle"):
            unknown = np.isnan(of[name + suffix])
            assert np.flatnonzero(unknown.sel(muscle=2)).tolist() == list(range(120, 170)), name + suffix
            assert not unknown.sel(muscle=1).any()
    assert np.isfinite(of[["position_sd", "velocity_sd", "disturbance_sd"]].to_array()).all()
    assert np.isfinite(of.activation_hat).all()
