"""The verdict: the right recording is not doubted, and each wrong one is, as what it is or may be."""

import dataclasses
import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import hillobs
from few_observers import few_observers
from hillobs.model.curves import MILLARD2012
from hillobs.studies.cli.reports.estimates.verdict import sentences
from hillobs.studies.estimate.run import estimate, recorded
from hillobs.studies.files.progress import unseen
from hillobs.studies.kalman.orders import Choice
from hillobs.studies.kalman.record import Record, settled
from hillobs.studies.kalman.run import causal_choices
from hillobs.studies.laboratory.muscles import MusclePair, read_muscles
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.verdict import likelihood, muscles, run
from hillobs.studies.verdict.finding import Finding
from hillobs.studies.verdict.likelihood import gains, weight
from hillobs.studies.verdict.run import Verdict, judged
from hillobs.studies.verdict.variants import Variant, variants
from random_recordings import drawn
from shipped_recording import MUSCLES, SHIPPED, part

Given = tuple[Recording, MusclePair]


@pytest.fixture(scope="module", autouse=True)
def _few() -> Iterator[None]:
    """Other curves are other libraries, in which a verdict asks for the tendons only."""
    with few_observers("kalman"):
        yield


@pytest.fixture(autouse=True)
def _without_millard(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """The filter with Millard's curves takes long to compile: they are weighed in the long run only."""
    if "chaos" not in request.keywords:

        def others(*given: object) -> list[Variant]:
            return [variant for variant in variants(*given) if variant.pair.muscle1.curves is not MILLARD2012]

        monkeypatch.setattr(muscles, "variants", others)


@pytest.fixture(scope="module")
def shipped() -> Given:
    """The first four seconds."""
    return part(read_recording(SHIPPED), slice(0, 800)), read_muscles(MUSCLES)


def scaled(name: str, factor: float) -> Callable[[Recording, MusclePair], Given]:
    def change(recording: Recording, pair: MusclePair) -> Given:
        each = [dataclasses.replace(m, **{name: getattr(m, name) * factor}) for m in (pair.muscle1, pair.muscle2)]
        return recording, dataclasses.replace(pair, muscle1=each[0], muscle2=each[1])

    return change


def measured(**columns: Callable[[Recording], np.ndarray]) -> Callable[[Recording, MusclePair], Given]:
    def change(recording: Recording, pair: MusclePair) -> Given:
        return recording.remeasured(**{name: of(recording) for name, of in columns.items()}), pair

    return change


def other_mass(factor: float) -> Callable[[Recording, MusclePair], Given]:
    return lambda recording, pair: (recording, dataclasses.replace(pair, mass=pair.mass * factor))


def other_curves(recording: Recording, pair: MusclePair) -> Given:
    text = MUSCLES.read_text().replace("degroote_fregly2016", "thelen2003")
    path = Path(recording.source).with_suffix(".toml")
    path.write_text(text)
    return recording, read_muscles(path)


# what was done, and words of the sentence that must name it
WRONG = {
    "F_max": (scaled("F_max", 0.4), "F_max"),
    "v_max": (scaled("v_max", 10.0), "v_max"),
    "l0-long": (scaled("optimal_fibre_length", 1.05), "optimal fibre lengths 5% smaller"),
    "l0-short": (scaled("optimal_fibre_length", 0.95), "optimal fibre lengths 5% larger"),
    "slack-length": (scaled("tendon_slack_length", 1.02), "tendon slack lengths 2% smaller"),
    "heavy": (other_mass(10.0), "a mass 0.1 times as large"),
    "light": (other_mass(0.1), "a mass 10 times as large"),
    "curves": (other_curves, "likelier with the curves of degroote_fregly2016"),
    "swapped": (measured(force_1=lambda r: r["force_2"], force_2=lambda r: r["force_1"]), "the muscles swapped"),
    "mirrored": (measured(position=lambda r: 0.62 - r["position"]), "measured from the other wall"),
    "kilonewtons": (measured(force_1=lambda r: r["force_1"] / 1e3, force_2=lambda r: r["force_2"] / 1e3), "in kN"),
    "millimetres": (measured(position=lambda r: r["position"] / 1e3), "in another unit, such as mm"),
    "still": (measured(position=lambda r: 0 * r["position"] + 0.31), "stands still"),
}
QUICK = ("l0-long", "swapped", "kilonewtons", "millimetres", "still")


def doubts(verdict: Verdict) -> str:
    return "\n".join(finding.sentence for finding in verdict.findings if finding.doubtful)


@pytest.mark.parametrize("weighed", ["without Millard", pytest.param("all", marks=pytest.mark.chaos)])
def test_the_right_recording_is_not_doubted(weighed: str, shipped: Given) -> None:
    verdict = hillobs.verdict(*shipped)
    assert doubts(verdict) == ""
    assert verdict.quality == "good"
    subjects = [finding.subject for finding in verdict.findings]
    assert subjects[:4] == ["innovations", "form", "bias", "muscles"]
    assert json.loads(json.dumps(verdict.as_dict(), allow_nan=False))["quality"] == "good"


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in QUICK else pytest.mark.chaos) for n in WRONG])
def test_what_is_wrong_is_named(name: str, shipped: Given, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    change, words = WRONG[name]
    recording, pair = shipped
    # the rest is told by more samples
    verdict = hillobs.verdict(*change(recording if name in QUICK else read_recording(SHIPPED), pair))
    assert verdict.quality == "doubtful"
    assert words in doubts(verdict), doubts(verdict)
    if name == "l0-long":
        # for a program
        answer = json.loads(json.dumps(verdict.as_dict(), allow_nan=False))
        (suspects,) = (found["suspects"] for found in answer["findings"] if found["subject"] == "muscles")
        assert (suspects[0]["number"], suspects[0]["factor"]) == ("optimal_fibre_length", 0.95)
        assert suspects[0]["log_likelihood"] == verdict.findings[-1].value


def test_the_same_samples_are_weighed_whatever_v_max_is(shipped: Given, monkeypatch: pytest.MonkeyPatch) -> None:
    """τ is another time with another v_max: a likelihood of other samples would be another one."""
    recording, pair = shipped
    case, record = recorded(recording, pair)
    choices = causal_choices(record, {"order_D": 2, "order_u": 3, "order_a": 3})
    counted = []

    def choose(other: Record, orders: object) -> tuple[Choice, Choice]:
        counted.append(settled(other.table(), other.settling)[:, -1].sum())
        return choices

    monkeypatch.setattr(likelihood, "causal_choices", choose)
    tried = [variant for variant in variants(recording, pair) if variant.name == "v_max"]
    found = list(gains(weight(record, choices, pair), {}, tried, record.settling / case.scales.rate))
    assert counted == [settled(record.table())[:, -1].sum()] * len(tried)
    # with the same densities nothing is gained but by the tendons, which know no v_max: only their lines differ
    assert max(abs(gain) for _, gain in found) < 5


@pytest.mark.parametrize("seed", [2003, pytest.param(2005, marks=pytest.mark.chaos)])
def test_right_muscles_whose_activations_jump_or_are_slow_are_not_doubted(seed: int) -> None:
    one = drawn(seed)
    verdict = hillobs.verdict(one.recording, one.pair)
    assert doubts(verdict) == ""
    told = [finding.sentence for finding in verdict.findings if finding.subject == "untold"]
    abrupt = "the recording cannot tell: optimal fibre lengths, tendon slack lengths, F_max, curves"
    assert told == ([abrupt] if one.kind == "abrupt" else [])


def test_of_a_long_recording_the_middle_is_weighed_and_that_is_said(
    shipped: Given, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording, pair = shipped
    monkeypatch.setattr(run, "_MOST", 600)
    estimates = estimate(recording, pair, "kalman")
    weighed = []
    monkeypatch.setattr(run, "of_muscles", lambda middle, *_: weighed.append(middle) or [])
    verdict = judged(recording, pair, estimates, unseen)
    (middle,) = weighed
    assert (len(middle), middle.time[0], middle.time[-1]) == (600, recording.time[100], recording.time[699])
    assert verdict.as_dict()["weighed"] == {"samples": 600, "of": 800, "between": [middle.time[0], middle.time[-1]]}
    first, *_ = sentences(verdict)
    assert first == (
        "verdict: nothing is doubted; the muscles' numbers are weighed by the 600 samples from 0.5 to 3.495 s, "
        "all else by all 800"
    )


def test_muscles_are_not_weighed_by_what_a_sensor_that_hangs_tells(shipped: Given) -> None:
    recording, pair = shipped
    frozen = np.where(recording.time < 1, recording["position"][0], recording["position"])
    verdict = hillobs.verdict(recording.remeasured(position=frozen), pair)
    assert "position is the same number from 0 to 0.995 s" in doubts(verdict)
    assert {finding.subject for finding in verdict.findings}.isdisjoint({"muscles", "form", "untold"})
    assert verdict.weighed == 0


@pytest.mark.parametrize(
    ("doubtful", "words"), [(1, "verdict: 1 of 2 findings is doubtful"), (2, "verdict: 2 of 2 findings are doubtful")]
)
def test_doubts_are_counted_in_english(doubtful: int, words: str) -> None:
    findings = [Finding("form", "it fits", 1.0, i < doubtful) for i in range(2)]
    assert next(sentences(Verdict(findings, 100, 100, (0.0, 1.0)))) == words
    assert next(sentences(Verdict(findings, 100, 0, (0.0, 1.0)))).startswith(f"{words}; the muscles' numbers are not")


def test_what_is_tried_is_tried_up_and_down_and_of_both_muscles(shipped: Given) -> None:
    recording, pair = shipped
    tried = list(variants(recording, pair))
    assert {variant.name for variant in tried} == {
        "optimal_fibre_length", "tendon_slack_length", "F_max", "v_max", "curves", "mass", "swapped", "mirrored",
    }  # fmt: skip
    for name in ("optimal_fibre_length", "tendon_slack_length", "F_max", "v_max"):
        usual = getattr(pair.muscle1, name)
        ratios = [getattr(v.pair.muscle1, name) / usual for v in tried if v.name == name]
        assert ratios == [getattr(v.pair.muscle2, name) / usual for v in tried if v.name == name]
        assert min(ratios) < 1 < max(ratios)
    assert {v.pair.muscle1.curves.name for v in tried if v.name == "curves"} == {"millard2012", "thelen2003"}
    assert all(v.pair.muscle1.numbers["tendon_strain"] == pair.muscle1.numbers["tendon_strain"] for v in tried)
    swapped, mirrored = (variant.recording for variant in tried[-2:])
    assert swapped["force_1"] is recording["force_2"]
    np.testing.assert_allclose(mirrored["position"] + recording["position"], pair.C)


def test_a_command_ends_with_the_verdict_and_writes_it(command, shipped: Given, tmp_path: Path) -> None:
    rows = as_csv(shipped[0])
    (tmp_path / "run.csv").write_text(rows)
    given = ("estimate", "run.csv", "--muscles", str(MUSCLES), "--observer", "kalman", "--no-figures")
    code, out, err = command(*given, "--json")
    assert (code, err.count("verdict: nothing is doubted")) == (0, 1)
    answer = json.loads(out)
    assert answer["verdict"]["quality"] == "good"
    result = hillobs.load(tmp_path / "estimates" / "estimates.nc")
    assert result.attrs["quality"] == "good"
    assert json.loads(result.attrs["verdict"]) == answer["verdict"]
    code, out, _ = command(*given, "--no-verdict")
    assert code == 0
    assert "verdict" not in out
    assert "quality" not in hillobs.load(tmp_path / "estimates" / "estimates.nc").attrs


def as_csv(recording: Recording) -> str:
    columns = zip(recording.time, recording["position"], recording["force_1"], recording["force_2"], strict=True)
    return "\n".join(["time,position,force_1,force_2", *(",".join(map(repr, map(float, row))) for row in columns)])
