"""Recordings of joints and any number of muscles: as accurate as promised, and the pair is one of them."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from hillobs.model.block import Symbols
from hillobs.model.skeleton.paths import constant_moment_arms
from hillobs.model.skeleton.tree import GROUND, SLIDER, Joint, Link, Tree
from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.scores import scores
from hillobs.studies.figures.estimate import estimate_sheet
from hillobs.studies.files.errors import RecordingError, ScenarioError
from hillobs.studies.laboratory.mechanisms.mechanism import Mechanism
from hillobs.studies.laboratory.mechanisms.reading import read_mechanism
from hillobs.studies.laboratory.muscles import read_muscles
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.laboratory.subject import subject_of
from places import DATA, RECORDINGS
from shipped_recording import CHAINS, DYNAMOMETER, HINGE, MUSCLES

pytestmark = pytest.mark.numerics

# RMSE of activations that high gain of both orders stays below; the sliding modes are within 1.3 times of high gain
CASES = {
    "hinge_pair_noisy.csv.gz": (HINGE, 0.0075, 0.0062),
    "dynamometer_noisy.csv.gz": (DYNAMOMETER, 0.016, 0.016),
}
ARMS = {
    "arm_noisy.csv.gz": (RECORDINGS / "arm.toml", 0.0075, 0.0062),
    "arm_smooth_noisy.csv.gz": (RECORDINGS / "arm.toml", 0.0075, 0.0062),
}
GAINS = {"high_gain_3.elbow.eps_h": 0.16, "high_gain_3.TRIlat.eps_L": 0.12, "high_gain_3.BRA.eps_L": 0.11}
FASTEST = 0.032  # rad/s


@pytest.mark.parametrize(
    "name",
    [*CASES, *(pytest.param(name, marks=pytest.mark.chaos) for name in ARMS)],
)
def test_one_rule_for_all_is_as_good_as_promised(name: str) -> None:
    folder = RECORDINGS if (RECORDINGS / name).exists() else DATA
    mechanism, order_2, order_3 = {**CASES, **ARMS}[name]
    found = {
        (score.observer, score.quantity): score
        for score in scores(estimate(folder / name, mechanism, CHAINS))
        if score.together
    }
    activation = {observer: found[observer, "activation"].rmse for observer in CHAINS}
    assert activation["high_gain"] <= order_2
    assert activation["high_gain_3"] <= order_3
    assert activation["kalman_constant"] <= order_2
    assert max(activation["sliding_mode"], activation["adaptive_sliding_mode"]) <= 1.3 * activation["high_gain"]
    velocity = found["high_gain", "velocity"]
    assert velocity.unit in ("rad/s", "m/s")
    assert velocity.rmse <= FASTEST


def as_a_mechanism() -> Mechanism:
    """The shipped pair: a slider between muscles of the lengths q and C − q."""
    pair = read_muscles(MUSCLES)
    tree = Tree(
        {"block": Link(pair.mass)}, {"mass": Joint(GROUND, "block", SLIDER, (1.0, 0.0, 0.0), range=(0.0, pair.C))}
    )
    muscles = {"muscle1": pair.muscle1, "muscle2": pair.muscle2}
    paths = {
        "muscle1": constant_moment_arms(0.0, {"mass": -1.0}),
        "muscle2": constant_moment_arms(pair.C, {"mass": 1.0}),
    }
    return Mechanism(tree, muscles, paths)


def test_the_pair_is_a_mechanism(short: Recording) -> None:
    """With the same gains to the last digits; the pair has one ε for both muscles."""
    mechanism = as_a_mechanism()
    subject = subject_of(mechanism)
    measured = dict(zip(subject.columns.required, short.measured.values(), strict=True))
    renamed = dataclasses.replace(short, measured=measured, columns=subject.columns, true={})
    gains = {"eps_h": 0.15, "eps_L": 0.05}
    pair = estimate(
        short, MUSCLES, "high_gain", changes={f"high_gain.{name}": v for name, v in gains.items()}, usual_doubt=False
    )
    owners = {"eps_h": ("mass",), "eps_L": ("muscle1", "muscle2")}
    changes = {f"high_gain.{of}.{name}": gains[name] for name, several in owners.items() for of in several}
    other = estimate(renamed, mechanism, "high_gain", changes=changes)
    for name in ("position", "velocity", "disturbance"):
        scale = float(abs(pair[f"{name}_hat"]).max())
        np.testing.assert_allclose(other[f"{name}_hat"].sel(joint="mass"), pair[f"{name}_hat"], atol=1e-11 * scale)
    for name in ("tendon_length", "fibre_length", "fibre_velocity", "activation"):
        np.testing.assert_allclose(other[f"{name}_hat"], pair[f"{name}_hat"], atol=1e-10)


def test_degrees_of_opensim_are_read_as_such(tmp_path: Path) -> None:
    recording = read_recording(DATA / "hinge_pair_noisy.csv.gz", known=subject_of(HINGE).columns)
    labels = [
        "time",
        "/jointset/r_elbow/r_elbow_flex/value",
        "/forceset/TRIlat|tendon_force",
        "/forceset/BRA|tendon_force",
    ]
    table = np.column_stack(
        [recording.time, np.degrees(recording["angle_elbow"]), recording["force_TRIlat"], recording["force_BRA"]]
    )
    rows = "\n".join("\t".join(map(repr, row)) for row in table.tolist())
    (tmp_path / "x.sto").write_text("x\ninDegrees=yes\nendheader\n" + "\t".join(labels) + "\n" + rows + "\n")
    read = read_recording(tmp_path / "x.sto", known=recording.columns)
    np.testing.assert_allclose(read["angle_elbow"], recording["angle_elbow"], rtol=1e-14)
    np.testing.assert_array_equal(read["force_BRA"], recording["force_BRA"])


def columns(recording: Recording, **changes: np.ndarray) -> dict[str, np.ndarray]:
    return {"time": recording.time, **recording.measured, **changes}


def test_what_is_wrong_is_one_sentence(tmp_path: Path, command) -> None:
    recording = read_recording(DATA / "hinge_pair_noisy.csv.gz", known=subject_of(HINGE).columns)
    few = {name: values[:100] for name, values in columns(recording).items()}

    def told(given: dict[str, np.ndarray], *arguments: str) -> str:
        rows = np.column_stack(list(given.values()))
        np.savetxt(tmp_path / "x.csv", rows, delimiter=",", header=",".join(given), comments="")
        code, _, err = command("estimate", str(tmp_path / "x.csv"), "--no-figures", *arguments)
        assert code == 2
        assert err.count("\n") == 1, err
        return err

    of_hinge = ("--mechanism", str(HINGE))
    assert "angle_elbow = 6" in told({**few, "angle_elbow": np.degrees(few["angle_elbow"])}, *of_hinge)
    assert "is it in degrees?" in told({**few, "angle_elbow": np.degrees(few["angle_elbow"])}, *of_hinge)
    without = {name: values for name, values in few.items() if name != "force_BRA"}
    assert "there is no column force_BRA" in told(without, *of_hinge)
    assert "F_max is 987.26 N; is it in another unit?" in told({**few, "force_BRA": 1e3 * few["force_BRA"]}, *of_hinge)
    fewer = {name: values[:40] for name, values in few.items()}
    assert "40 rows of numbers" in told(fewer, *of_hinge, "--observer", "kalman")
    assert "longer than the recording" in told(few, *of_hinge, "--observer", "kalman", "--lag", "2s")
    assert "unknown path" in told(few, *of_hinge, "--observer", "kalman", "--set", "kalman.s_D=0.1")
    assert "kalman.elbow.order_D" in told(few, *of_hinge, "--observer", "kalman", "--set", "kalman.elbow.order_D=4")
    assert "needs either --muscles" in told(few)
    assert "needs either --muscles" in told(few, *of_hinge, "--muscles", str(MUSCLES))
    assert "unknown number 'mass' in doubt" in told(few, *of_hinge, "--doubt", "mass=3%")
    assert "unknown path" in told(few, *of_hinge, "--set", "high_gain.eps_h=0.1")


def test_gains_are_those_of_each_chain(hinge: xr.Dataset) -> None:
    gains = json.loads(hinge.attrs["gains"])["high_gain"]
    assert list(gains) == ["high_gain.elbow.eps_h", "high_gain.TRIlat.eps_L", "high_gain.BRA.eps_L"]
    assert not json.loads(hinge.attrs["violated_conditions"])
    by_hand = estimate(
        DATA / "hinge_pair_noisy.csv.gz", HINGE, "high_gain", changes={"high_gain.BRA.h21": -1.0}, keep_every=100
    )
    assert json.loads(by_hand.attrs["violated_conditions"])["high_gain"] == ["BRA: h21 > 0: -1 > 0 does not hold"]


def test_a_mechanism_asks_for_a_joint() -> None:
    mechanism = read_mechanism(DYNAMOMETER)
    still = {
        name: dataclasses.replace(joint, locked=0.3, prescribed=False) for name, joint in mechanism.tree.joints.items()
    }
    tree = dataclasses.replace(mechanism.tree, joints=still)
    with pytest.raises(ScenarioError, match="nothing moves that could be estimated"):
        dataclasses.replace(mechanism, tree=tree)


def test_a_joint_without_a_range_may_turn_round_and_round() -> None:
    mechanism = read_mechanism(HINGE)
    turning = {name: dataclasses.replace(joint, range=None) for name, joint in mechanism.tree.joints.items()}
    subject = subject_of(dataclasses.replace(mechanism, tree=dataclasses.replace(mechanism.tree, joints=turning)))
    assert subject.system.reach("elbow", Symbols()) > 100 * 2 * np.pi


def test_what_moves_a_prescribed_joint_is_not_known() -> None:
    data = estimate(DATA / "dynamometer_noisy.csv.gz", DYNAMOMETER, "high_gain", keep_every=100)
    assert data.disturbance_hat.isnull().all()
    assert np.isfinite(data.velocity_hat).all()
    assert "disturbance" not in {score.quantity for score in scores(data)}
    labels = [axes.get_ylabel() for axes in estimate_sheet(data).axes]
    assert any(label.startswith("velocity") for label in labels)
    assert not any(label.startswith("external") for label in labels)


def test_the_acceleration_of_a_prescribed_joint_counts_in_the_others_torques() -> None:
    """M q̈ + h = R F + torque for the free joint, whatever both accelerations are."""
    arm = read_mechanism(RECORDINGS / "arm.toml")
    shoulder = dataclasses.replace(arm.tree.joints["shoulder"], prescribed=True)
    tree = dataclasses.replace(arm.tree, joints={**arm.tree.joints, "shoulder": shoulder})
    laws, free = (subject_of(dataclasses.replace(arm, tree=of)).laws for of in (tree, arm.tree))
    random = np.random.default_rng(3)
    q, dq, Delta = random.uniform(0.1, 0.5, (3, 20, 2))
    F = random.uniform(0.1, 0.5, (20, 6))
    torques = laws.forces(q, Delta)
    assert np.isnan(torques[:, 0]).all()
    # where both are free these accelerations need the torque M (q̈ − α)
    ddq = laws.accelerations(q, dq, F) + Delta
    expected = free.forces(q, ddq - free.accelerations(q, dq, F))
    np.testing.assert_allclose(torques[:, 1], expected[:, 1], atol=1e-12 * np.abs(expected).max())


def test_a_pair_has_no_columns_of_joints(short: Recording) -> None:
    with pytest.raises(RecordingError, match="measured must be position, force_1, force_2"):
        short.remeasured(angle_elbow=short.time)


@pytest.mark.parametrize(
    "number", ["optimal_fibre_length", "pennation", pytest.param("F_max", marks=pytest.mark.chaos)]
)
def test_a_changed_number_moves_the_estimates_by_its_band(number: str) -> None:
    """By a thousandth: noise of û is in the rate of the tendon's length, and the square of the step is left."""
    recording = read_recording(DATA / "hinge_pair_noisy.csv.gz", known=subject_of(HINGE).columns)
    mechanism = read_mechanism(HINGE)
    usual, step = mechanism.muscles["TRIlat"], 1e-3
    muscle = dataclasses.replace(usual, **{number: getattr(usual, number) * (1 + step)})
    # the same gains, whatever the muscle; another size is another library
    moved, found = (
        estimate(recording, of, "high_gain_3", changes=GAINS, doubt=doubt, usual_doubt=False)
        for of, doubt in (
            (dataclasses.replace(mechanism, muscles={**mechanism.muscles, "TRIlat": muscle}), {}),
            (mechanism, {f"TRIlat.{number}": f"{100 * step!r}%"}),
        )
    )
    late = slice(1.0, None)
    for name in ("fibre_length", "activation"):
        move, band = (
            of.sel(muscle="TRIlat", time=late).isel(observer=0)
            for of in (moved[f"{name}_hat"] - found[f"{name}_hat"], found[f"{name}_sd_muscle"])
        )
        assert float(np.sqrt(((abs(move) - band) ** 2).mean() / (move**2).mean())) < 0.02, name
    assert not found.activation_sd_muscle.sel(muscle="BRA").any()


def test_a_biased_force_moves_the_torque_by_its_moment_arm() -> None:
    biased = estimate(
        DATA / "hinge_pair_noisy.csv.gz", HINGE, "high_gain", doubt={"BRA.force_bias": "2N"}, usual_doubt=False
    )
    arms = subject_of(HINGE).laws.moment_arms(biased.position_hat.values)[0, :, 1, 0] * subject_of(HINGE).scales.length
    np.testing.assert_allclose(biased.disturbance_sd_muscle[0, :, 0], 2 * abs(arms), rtol=1e-12)
