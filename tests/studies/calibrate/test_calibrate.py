"""Numbers of a muscle from trials: found where trials tell them, and as sure as is said."""

import dataclasses

import numpy as np
import pytest
import xarray as xr

from held_trials import MAXIMAL, PAIR, PASSIVE, forces, guessed, noisy, trial, wrong
from hillobs.model.curves import CURVES
from hillobs.studies.calibrate.result import Calibration, Number
from hillobs.studies.calibrate.run import calibrate
from hillobs.studies.calibrate.trial import LEVEL_SDS, Trial
from hillobs.studies.cli.reports.calibrate import notes
from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.scores import SETTLED, WITHIN_95
from hillobs.studies.laboratory.mechanisms.mechanism import Mechanism
from hillobs.studies.laboratory.mechanisms.reading import read_mechanism
from hillobs.studies.laboratory.muscles import Muscle, MusclePair, read_muscles
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.laboratory.subject import Subject, subject_of
from places import RECORDINGS
from shipped_recording import MUSCLES, SHIPPED

pytestmark = pytest.mark.numerics

# of muscle 1 alone
STRETCHED = {"muscle1": 0.0}
# in %: what research on such trials takes for good enough
NEEDED = {"optimal_fibre_length": 0.3, "tendon_slack_length": 0.2, "passive_strain": 0.4, "F_max": 1.0}
DRAWS = 24


def error(number: Number) -> float:
    """As a part of the truth."""
    return number.value / PAIR.muscle1.values[number.name] - 1


def of_muscle1(found: Calibration) -> dict[str, Number]:
    return {number.name: number for number in found.numbers if number.muscle == "muscle1"}


def both(passive: Recording, three: Recording, seed: int) -> list[Trial]:
    return [trial(noisy(passive, seed), STRETCHED), trial(noisy(three, seed + 1), MAXIMAL)]


def test_numbers_are_found_within_what_is_said_of_them(five: Recording) -> None:
    """Within four of their standard deviations, which of the important ones are below half a per cent."""
    found = of_muscle1(calibrate([trial(noisy(five, 1), MAXIMAL)], guessed(1)))
    for name, number in found.items():
        assert abs(error(number)) < 4 * number.sd / number.value, name
    assert all(found[name].sd < 0.005 * found[name].value for name in NEEDED)


def test_the_less_noise_the_nearer_the_truth(passive: Recording, three: Recording) -> None:
    """What is left without noise is the smoother's, which takes 0.15 s of motion for a little smoother than it is."""
    quiet = [
        noisy(recording, 3, force=1e-5).remeasured(position=recording["position"]) for recording in (passive, three)
    ]
    trials = [trial(quiet[0], STRETCHED), trial(quiet[1], MAXIMAL)]
    found = of_muscle1(calibrate(trials, guessed(2)))
    assert all(abs(error(found[name])) < 1e-3 for name in NEEDED)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("millard2012", "the curves do not fit, whatever their numbers"),
        # they fit, with a fibre that nobody has
        ("thelen2003", "muscle1.optimal_fibre_length is 4"),
    ],
)
def test_curves_of_another_shape_are_noticed(name: str, sentence: str, five: Recording) -> None:
    def other(muscle: Muscle) -> Muscle:
        return dataclasses.replace(muscle, curves=CURVES[name], numbers={})

    trials, right = [trial(noisy(five, 1), MAXIMAL)], guessed(1)
    others = dataclasses.replace(right, muscle1=other(right.muscle1), muscle2=other(right.muscle2))
    assert any(sentence in said for said in notes(calibrate(trials, others)))
    assert list(notes(calibrate(trials, right))) == []


def test_what_a_passive_stretch_cannot_tell_is_said(passive: Recording) -> None:
    """It pulls with fL nowhere, so nothing is told of a fibre's speed or largest force."""
    found = calibrate([trial(noisy(passive, 1), PASSIVE)], guessed(1))
    for muscle in PASSIVE:
        open_ = [direction for direction in found.untold if direction.muscle == muscle]
        (alone,) = [direction for direction in open_ if list(direction.parts) == ["v_max"]]
        assert alone.sd == pytest.approx(1)
        assert any({"optimal_fibre_length", "tendon_slack_length"} <= set(direction.parts) for direction in open_)
    said = list(notes(found))
    assert any(
        "do not tell v_max, of which ± 20 % are left" in sentence and "lets the muscle shorten" in sentence
        for sentence in said
    )
    assert any("tell optimal_fibre_length, tendon_slack_length" in sentence for sentence in said)


def test_more_trials_tell_no_less(passive: Recording, three: Recording) -> None:
    """Information adds: no direction of one trial's covariance grows by another trial."""
    alone = of_muscle1(calibrate([trial(noisy(three, 5), MAXIMAL)], guessed(4)))
    together = of_muscle1(calibrate(both(passive, three, 4), guessed(4)))
    for name, number in together.items():
        assert number.left <= 1 + 1e-9
        # weights of either fit are those of its own numbers
        assert number.left < 1.2 * alone[name].left, name


def test_a_level_that_is_unsure_makes_the_largest_force_unsure(three: Recording, passive: Recording) -> None:
    """A level that is off by 2 % is a force that is off by 2 %, whatever the trial."""
    trials = both(passive, three, 6)
    unsure = [trials[0], Trial(trials[1].recording, MAXIMAL)]
    found = of_muscle1(calibrate(unsure, guessed(6)))["F_max"]
    assert 0.01 < found.sd / found.value < 0.025
    sure = of_muscle1(calibrate(trials, guessed(6)))["F_max"]
    assert sure.sd < 0.4 * found.sd


def test_outliers_count_less_and_are_named(five: Recording) -> None:
    seen = noisy(five, 7)
    force = seen["force_1"].copy()
    force[500:520] += 400.0
    found = calibrate([trial(seen.remeasured(force_1=force), MAXIMAL)], guessed(7))
    (misfit,) = found.misfits
    assert misfit.outliers
    assert all(2.3 < time < 2.8 for time in misfit.outliers)
    clean = of_muscle1(calibrate([trial(seen, MAXIMAL)], guessed(7)))
    for name in NEEDED:
        assert abs(error(of_muscle1(found)[name]) - error(clean[name])) < 0.02, name
    assert any("outliers count less" in sentence for sentence in notes(found))


def calibrated_by_opensim(recording: Recording, subject: Subject, guess: MusclePair | Mechanism) -> Calibration:
    """By activations that the recording knows, since it is simulated."""
    columns = dict(zip(subject.muscles, subject.names["activation"], strict=True))
    known = {name: recording.true[column] for name, column in columns.items()}
    return calibrate([Trial(recording, known, dict.fromkeys(known, 0.0))], guess)


def test_muscles_of_opensim_are_found_by_their_activations() -> None:
    """Ten seconds of OpenSim's own muscle and integrator, which know nothing of this model."""
    found = calibrated_by_opensim(
        read_recording(SHIPPED), subject_of(MUSCLES), dataclasses.replace(guessed(3), C=read_muscles(MUSCLES).C)
    )
    for number in found.numbers:
        assert abs(error(number)) < 4 * number.sd / number.value, (number.muscle, number.name)
        assert number.name not in NEEDED or abs(error(number)) < 0.01, (number.muscle, number.name)
    assert all(misfit.fits for misfit in found.misfits)


@pytest.mark.chaos
def test_the_muscles_of_an_arm_of_opensim_are_found_by_their_activations() -> None:
    """Six muscles over two joints, pennate ones too: all that is told to a twentieth, within four of what is said."""
    arm = read_mechanism(RECORDINGS / "arm.toml")
    subject, random = subject_of(arm), np.random.default_rng(0)
    guess = dataclasses.replace(arm, muscles={name: wrong(muscle, random) for name, muscle in arm.muscles.items()})
    recording = read_recording(RECORDINGS / "arm_noisy.csv.gz", known=subject.columns)
    for number in calibrated_by_opensim(recording, subject, guess).numbers:
        off = number.value / arm.muscles[number.muscle].values[number.name] - 1
        assert abs(off) < 4 * number.sd / number.value, (number.muscle, number.name)
        assert number.sd > 0.05 * number.value or abs(off) < 0.05, (number.muscle, number.name)


def test_a_muscle_that_is_calibrated_is_estimated_within_its_band(passive: Recording, three: Recording) -> None:
    """The recording is OpenSim's, of the same muscles; what is left of the error is that of the noise."""
    guess, pair, recording = guessed(5), read_muscles(MUSCLES), read_recording(SHIPPED).part(slice(0, 1000))
    found = calibrate([Trial(noisy(passive, 1), STRETCHED), Trial(noisy(three, 2), MAXIMAL)], guess).muscles

    def estimated(muscle: Muscle) -> xr.Dataset:
        both_muscles = dataclasses.replace(pair, muscle1=muscle, muscle2=muscle)
        told = (
            estimate(recording, both_muscles, "kalman", form="u", smooth=True)
            .isel(observer=0)
            .sel(time=slice(SETTLED, None))
        )
        return told.assign(error=told.activation_hat - told.true_activation)

    before, after = estimated(guess.muscle1), estimated(found.muscle1)
    assert rms(after.error) < 0.1 * rms(before.error)
    assert float((abs(after.error) < WITHIN_95 * after.activation_sd).mean()) > 0.9


def rms(values: xr.DataArray) -> float:
    return float(np.sqrt((values**2).mean()))


def at_level(recording: Recording, activation: float) -> Recording:
    """The same with another activation of muscle 1; none is below 0."""
    return recording.remeasured(force_1=forces(PAIR.muscle1, recording["position"], max(activation, 0.0)))


@pytest.mark.chaos
@pytest.mark.parametrize("levels", [0.0, 1.0], ids=["exact", "unsure"])
def test_many_draws_err_as_little_and_as_much_as_is_said(
    five: Recording, passive: Recording, three: Recording, levels: float
) -> None:
    """In 24 draws of noise, level and guess rms(error/sd) is 1 if the sd is right, and from 0.71 to 1.29 by chance."""
    sds = {"passive": levels * LEVEL_SDS["passive"].default, "active": levels * LEVEL_SDS["active"].default}
    protocols = {"five": [(five, MAXIMAL)], "stretch and three": [(passive, STRETCHED), (three, MAXIMAL)]}
    for protocol, kinds in protocols.items():
        errors, ratios = [], []
        for draw in range(DRAWS):
            random, trials = np.random.default_rng(draw), []
            for i, (recording, activations) in enumerate(kinds):
                sd = sds["active" if activations["muscle1"] else "passive"]
                # what was measured was not quite at the level that is said
                seen = at_level(recording, activations["muscle1"] + sd * random.normal())
                trials.append(trial(noisy(seen, 100 * draw + i), activations, sd))
            found = of_muscle1(calibrate(trials, guessed(draw)))
            errors.append([abs(error(number)) for number in found.values()])
            ratios.append([error(number) / (number.sd / number.value) for number in found.values()])
        medians = dict(zip(found, 100 * np.median(errors, axis=0), strict=True))
        spread = dict(zip(found, np.sqrt(np.mean(np.square(ratios), axis=0)), strict=True))
        print(f"{protocol}, levels {levels:g}: median |error| in % {rounded(medians)}, rms(error/sd) {rounded(spread)}")
        assert all(0.7 < spread[name] < 1.4 for name in spread), protocol
        # a level that is off by 2 % is a largest force that is, and all that is measured in it
        assert levels or all(medians[name] < most for name, most in NEEDED.items()), protocol


def rounded(values: dict[str, float]) -> dict[str, float]:
    return {name: round(float(value), 2) for name, value in values.items()}
