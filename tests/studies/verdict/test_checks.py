"""What looks wrong before any likelihood is asked, in every sample of a recording."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hillobs.model.arrays import Array
from hillobs.studies.cli import estimate as estimate_command
from hillobs.studies.cli.shell.stopping import Stopped
from hillobs.studies.estimate.run import estimate, recorded
from hillobs.studies.kalman.run import causal_inputs
from hillobs.studies.laboratory.muscles import read_muscles
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.verdict.checks import of_estimates, of_measurements, of_sensors
from hillobs.studies.verdict.finding import Finding
from hillobs.studies.verdict.innovations import of_innovations
from hillobs.studies.verdict.muscles import bias
from hillobs.studies.verdict.run import of_all
from shipped_recording import MUSCLES, SHIPPED, part


@pytest.fixture(scope="module")
def short() -> Recording:
    """The first 2 s."""
    return part(read_recording(SHIPPED), slice(0, 400))


def findings(recording: Recording, **columns: Array) -> list[Finding]:
    case, _ = recorded(recording.remeasured(**columns), read_muscles(MUSCLES))
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
    assert "in kN" in "".join(doubted(short, force_1=short["force_1"] / 1e3))


def test_forces_that_explain_nothing_make_no_ratio() -> None:
    still, moved = np.zeros(400), np.sin(np.arange(400.0))
    assert list(of_estimates(still, moved, [0.0, 0.0])) == []
    (finding,) = of_estimates(moved / 810, moved, [0.0, 0.0])
    assert "accelerates 810 times as much" in finding.sentence


def test_a_sensor_that_hangs_is_named_with_its_time_and_one_that_is_at_rest_is_not(short: Recording) -> None:
    def sensors(recording: Recording) -> list[Finding]:
        case, _ = recorded(recording, read_muscles(MUSCLES))
        return list(of_sensors(case))

    n = np.arange(len(short))
    assert sensors(short) == []
    frozen = np.where((n >= 100) & (n < 200), short["position"][100], short["position"])
    (finding,) = sensors(short.remeasured(position=frozen))
    assert finding.doubtful
    assert finding.when == pytest.approx((0.5, 0.995))
    assert finding.sentence.startswith("position is the same number from 0.5 to 0.995 s")
    # at the end of its range
    limit = np.quantile(short["force_1"], 0.6)
    (finding,) = sensors(short.remeasured(force_1=np.minimum(short["force_1"], limit)))
    assert finding.sentence.startswith("force_1")
    # a slack tendon, whose noise was cut off
    slack = np.where(n < 200, 0.0, short["force_2"])
    assert sensors(short.remeasured(force_2=slack)) == []
    # a mass at rest, as coarse digits or a simulation tell it, and every sample four times
    still = 0.31 + 0.01 * np.maximum(n - 200, 0) / 200
    assert sensors(short.remeasured(position=np.round(still, 4))) == []
    assert sensors(short.remeasured(position=still)) == []
    assert sensors(short.remeasured(position=short["position"][n // 4 * 4])) == []


def white(n: int = 4000) -> tuple[Array, Array]:
    """Times, and innovations over their standard deviations as they should be."""
    return np.arange(n) * 1e-3, np.random.default_rng(2).normal(size=(n, 3))


def test_innovations_are_judged_over_the_whole_recording_and_by_parts_of_it() -> None:
    time, ratios = white()
    (right,) = of_innovations(time, ratios, 1e-3)
    assert not right.doubtful
    assert "of position, force_1, force_2 over their standard deviations" in right.sentence
    # a few samples are no change, nor what does not count
    wild = ratios.copy()
    wild[500:520] *= 5
    ratios[3000:3010] = np.nan
    assert [finding.doubtful for finding in of_innovations(time, wild, 1e-3)] == [False]
    assert [finding.doubtful for finding in of_innovations(time, ratios, 1e-3)] == [False]
    ratios[600:1000, 1] *= 0.2
    assert [finding.doubtful for finding in of_innovations(time, ratios, 1e-3)] == [False, True]
    *_, changed = of_innovations(time, ratios, 1e-3)
    assert changed.when == pytest.approx((0.6, 0.999))
    assert "from 0.6 to 0.999 s innovations of force_1 are 0.2 times as large as usual" in changed.sentence
    ratios[3600:, [0, 2]] *= 4
    whole, changed = of_innovations(time, ratios, 1e-3)
    assert whole.doubtful
    assert "a number by hand" in whole.sentence
    assert "in 10% of the recording there are other changes" in changed.sentence


def test_innovations_that_are_not_white_are_told_once() -> None:
    time, ratios = white()
    slow = np.cumsum(ratios[:, :1], axis=0) / 30
    (finding,) = of_innovations(time, np.hstack([slow, ratios[:, 1:]]), 1e-3)
    assert finding.doubtful
    assert "(0 is right): noise that is not white" in finding.sentence
    assert "uneven steps" not in finding.sentence
    uneven = time + 2e-4 * np.sin(1e4 * time)
    (finding,) = of_innovations(uneven, np.hstack([slow, ratios[:, 1:]]), 1e-3)
    assert "uneven steps" in finding.sentence
    (finding,) = of_innovations(time, ratios, 1e-9)
    assert not finding.doubtful
    (finding,) = of_innovations(time, np.full_like(ratios, np.nan), 1e-3)
    assert not finding.doubtful


def test_what_was_estimated_is_judged_with_its_numbers_by_hand(short: Recording) -> None:
    pair = read_muscles(MUSCLES)

    def sentences(changes: dict[str, float]) -> list[str]:
        estimates = estimate(short, pair, ["kalman", "high_gain"], changes=changes)
        return [finding.sentence for finding in of_all(short, pair, estimates) if finding.doubtful]

    assert sentences({"high_gain.eps_h": 0.3}) == []
    (sentence,) = sentences({"kalman.sigma_1": 0.02, "kalman.s_D": 1e-6})
    assert sentence.startswith("innovations of position")


def test_a_bias_would_change_activations_that_are_limited_too(short: Recording) -> None:
    pair = read_muscles(MUSCLES)
    weak = [dataclasses.replace(muscle, F_max=muscle.F_max / 5) for muscle in (pair.muscle1, pair.muscle2)]
    changes = []
    for muscles in (pair, dataclasses.replace(pair, muscle1=weak[0], muscle2=weak[1])):
        case, record = recorded(short, muscles)
        (finding,) = bias(case, record, causal_inputs(record, {"order_D": 2, "order_u": 2}))
        changes.append(finding.value)
    # 1 % of F_max is a part of the force, whatever F_max is; the length force of the weak are larger
    assert changes[1] == pytest.approx(changes[0], rel=0.5)


@pytest.mark.parametrize("end", [ZeroDivisionError, Stopped])
def test_estimates_are_written_whatever_becomes_of_the_verdict(
    end: type[BaseException],
    short: Recording,
    command: Callable[..., tuple[int, str, str]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    columns = np.column_stack([short.time, short["position"], short["force_1"], short["force_2"]])
    np.savetxt("run.csv", columns, delimiter=",", header="time,position,force_1,force_2", comments="")

    def fails(*arguments: object) -> None:
        raise end

    monkeypatch.setattr(estimate_command, "judged", fails)
    with pytest.raises(end) as caught:
        command("estimate", "run.csv", "--muscles", str(MUSCLES), "--observer", "kalman", "--no-figures")
    assert {path.suffix for path in Path("estimates").iterdir()} >= {".nc", ".csv", ".sto"}
    # who stops it is told where they are
    told = ["the estimates are in estimates, without a verdict"] if end is Stopped else []
    assert getattr(caught.value, "__notes__", []) == told
