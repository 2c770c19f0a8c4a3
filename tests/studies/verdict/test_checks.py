"""What looks wrong before any likelihood is asked, in every sample of a recording."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hillobs.model.arrays import Array
from hillobs.studies.cli import estimate as estimate_command
from hillobs.studies.estimate.run import recorded
from hillobs.studies.laboratory.muscles import read_muscles
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.verdict.checks import of_estimates, of_measurements
from hillobs.studies.verdict.finding import Finding
from shipped_recording import MUSCLES, SHIPPED, part


@pytest.fixture(scope="module")
def short() -> Recording:
    """The first 2 s."""
    return part(read_recording(SHIPPED), slice(0, 400))


def findings(recording: Recording, **columns: Array) -> list[Finding]:
    case, _ = recorded(dataclasses.replace(recording, **columns), read_muscles(MUSCLES))
    return list(of_measurements(case))


def doubted(recording: Recording, **columns: Array) -> list[str]:
    return [finding.sentence for finding in findings(recording, **columns) if finding.doubtful]


def test_nothing_is_wrong_with_the_right_recording(short: Recording) -> None:
    assert findings(short) == []


def test_forces_that_stand_still_are_of_a_dead_sensor_and_not_in_kilonewtons(short: Recording) -> None:
    n = len(short)
    assert doubted(short, force_1=np.full(n, 120.0), force_2=np.zeros(n)) == [
        "force_1 stands still within its noise: a dead sensor or amplifier?",
        "force_2 is 0 throughout: a dead sensor, or a muscle that is slack",
    ]
    noise = np.random.default_rng(1).normal(size=n)
    (sentence,) = doubted(short, force_2=120 + 5 * noise)
    assert sentence.startswith("force_2 stands still")
    (sentence,) = doubted(short, position=0.31 + 1e-4 * noise)
    assert sentence.startswith("position stands still")
    assert "in kN" in "".join(doubted(short, force_1=short.force_1 / 1e3))


def test_forces_that_explain_nothing_make_no_ratio(short: Recording) -> None:
    case, _ = recorded(short, read_muscles(MUSCLES))
    still, moved = np.zeros(400), np.sin(np.arange(400.0))
    assert list(of_estimates(case, still, moved, [0.0, 0.0])) == []
    (finding,) = of_estimates(case, moved / 810, moved, [0.0, 0.0])
    assert "accelerates 810 times as much" in finding.sentence


def test_estimates_are_written_whatever_becomes_of_the_verdict(
    short: Recording, command: Callable[..., tuple[int, str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    columns = np.column_stack([short.time, short.position, short.force_1, short.force_2])
    np.savetxt("run.csv", columns, delimiter=",", header="time,position,force_1,force_2", comments="")

    def fails(*arguments: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(estimate_command, "verdict", fails)
    with pytest.raises(ZeroDivisionError):
        command("estimate", "run.csv", "--muscles", str(MUSCLES), "--observer", "kalman", "--no-figures")
    assert {path.suffix for path in Path("estimates").iterdir()} >= {".nc", ".csv", ".sto"}
