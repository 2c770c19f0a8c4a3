"""What sensors determine of joints and muscles, and why constants are easier to know than functions of time."""

import dataclasses
import json

import pytest

from hillobs import observability
from hillobs.model.curves import MILLARD2012
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.mechanisms.reading import read_mechanism
from hillobs.studies.laboratory.subject import subject_of
from hillobs.studies.observability.point import answer, rest_point
from hillobs.studies.observability.question import pose_mechanism
from places import RECORDINGS

HINGE, ARM = str(RECORDINGS / "hinge_pair.toml"), str(RECORDINGS / "arm.toml")


def test_all_sensors_of_a_joint_and_two_muscles_determine_inputs_and_torque() -> None:
    for unknown in ("u", "a"):
        hinge = observability(mechanism=HINGE, unknown=unknown)
        assert hinge.verdict.ranks[:3] == (3, 6, 7)
        assert hinge.lost_as_functions == ()


def test_an_arm_of_six_muscles_needs_the_second_derivative() -> None:
    arm = observability(mechanism=ARM, unknown="u", order=2)
    assert arm.verdict.ranks == (8, 16, 18)
    assert arm.verdict.full
    assert arm.lost_as_functions == ()


def test_fewer_sensors_than_unknowns_determine_constants_but_no_functions() -> None:
    # the rank of constants grows with each order; an unknown function takes an output of its own
    pair = observability(sensors=("x1", "F1"), unknown="u")
    assert pair.verdict.full
    assert pair.lost_as_functions == ("x4", "Delta", "u2")
    hinge = observability(mechanism=HINGE, sensors=("elbow", "TRIlat"), unknown="u")
    assert hinge.verdict.full
    assert hinge.lost_as_functions == ("BRA.L_S", "elbow.Delta", "BRA.u")


def test_fibre_lengths_stand_in_for_a_position() -> None:
    """x₁ = L_C1 + x₃, so that functions are determined although each sensor alone sees u₁ or u₂ first."""
    assert observability(sensors=("F1", "F2", "L_C1", "L_C2"), unknown="u").lost_as_functions == ()


def test_known_inputs_leave_no_function_to_tell() -> None:
    assert observability(mechanism=HINGE).lost_as_functions is None


def test_a_slack_tendon_of_a_mechanism_is_lost_with_its_input() -> None:
    # the force of this tendon ends at its slack length; De Groote's, which the file has, never quite does
    hinge = read_mechanism(HINGE)
    millard = {name: dataclasses.replace(muscle, curves=MILLARD2012) for name, muscle in hinge.muscles.items()}
    subject = subject_of(dataclasses.replace(hinge, muscles=millard))
    question = pose_mechanism(subject, unknown="u")
    rest = rest_point(subject, question)
    slack, _ = question.tendon("BRA").edges
    lost = answer(question, {**rest, "BRA.L_S": 0.99 * slack})
    assert lost.verdict.unobservable == ("BRA.L_S", "BRA.u")
    assert lost.regions["tendon BRA"] == "slack"


def test_sensors_of_a_mechanism_have_the_names_of_its_file() -> None:
    with pytest.raises(
        ScenarioError, match=r"unknown sensor 'knee'; there are elbow, TRIlat, BRA, TRIlat\.L_C, BRA\.L_C"
    ):
        observability(mechanism=HINGE, sensors=("knee",))
    with pytest.raises(ScenarioError, match=r"no coordinate 'x1'; there are elbow\.q"):
        observability(mechanism=HINGE, place={"x1": 2.6})


def test_the_command_answers_for_a_mechanism(command) -> None:
    code, out, _ = command("observability", "--mechanism", HINGE, "--unknown", "u")
    assert code == 0
    assert "Δ of elbow and u of TRIlat, BRA unknown: rank 7 of 7, observable" in out
    assert "as functions of time, not constants: all are determined" in out
    code, out, _ = command(
        "observability", "--mechanism", HINGE, "--outputs", "elbow,TRIlat", "--unknown", "u", "--json"
    )
    assert code == 0
    assert json.loads(out)["lost_as_functions"] == ["BRA.L_S", "elbow.Delta", "BRA.u"]
    code, out, _ = command("observability", "--mechanism", HINGE, "--outputs", "elbow", "--order", "1")
    assert code == 1
    assert "0, 1, …: 1, 2; a higher --order may add to it" in out
    for option in (("slack",), ("--along",), ("--map", "x1,x3"), ("--set", "duration=1")):
        code, _, err = command("observability", "--mechanism", HINGE, *option)
        assert code == 2
        assert "go without --mechanism" in err
