"""The verdict on joints and muscles: right recordings are not doubted, and each wrong one is, as what it may be."""

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import hillobs
from hillobs.studies.laboratory.mechanisms.mechanism import Mechanism
from hillobs.studies.laboratory.mechanisms.reading import read_mechanism
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.laboratory.subject import subject_of
from hillobs.studies.verdict.run import Verdict
from places import DATA, RECORDINGS
from random_recordings import as_mechanism, drawn
from shipped_recording import DYNAMOMETER, HINGE, part

pytestmark = pytest.mark.numerics

Given = tuple[Recording, Mechanism]
ARM = RECORDINGS / "arm.toml"
RIGHT = {
    "hinge": (DATA / "hinge_pair_noisy.csv.gz", HINGE),
    "dynamometer": (DATA / "dynamometer_noisy.csv.gz", DYNAMOMETER),
    "arm_random": (RECORDINGS / "arm_noisy.csv.gz", ARM),
    "arm_smooth": (DATA / "arm_smooth_noisy.csv.gz", ARM),
}


def given(name: str, samples: int | None = None) -> Given:
    path, file = RIGHT[name]
    mechanism = read_mechanism(file)
    read = read_recording(path, known=subject_of(mechanism).columns)
    return part(read, slice(0, samples)), mechanism


def other_muscle(of: str, number: str, factor: float) -> Callable[[Recording, Mechanism], Given]:
    def change(recording: Recording, mechanism: Mechanism) -> Given:
        muscle = mechanism.muscles[of]
        other = dataclasses.replace(muscle, **{number: getattr(muscle, number) * factor})
        return recording, dataclasses.replace(mechanism, muscles={**mechanism.muscles, of: other})

    return change


def measured(**columns: Callable[[Recording], np.ndarray]) -> Callable[[Recording, Mechanism], Given]:
    return lambda recording, mechanism: (
        recording.remeasured(**{name: of(recording) for name, of in columns.items()}),
        mechanism,
    )


def other_masses(factor: float) -> Callable[[Recording, Mechanism], Given]:
    def change(recording: Recording, mechanism: Mechanism) -> Given:
        links = {
            name: dataclasses.replace(link, mass=link.mass * factor, inertia=tuple(factor * v for v in link.inertia))
            for name, link in mechanism.tree.links.items()
        }
        return recording, dataclasses.replace(mechanism, tree=dataclasses.replace(mechanism.tree, links=links))

    return change


def held(recording: Recording) -> np.ndarray:
    """The force of BRA, which hangs for a second."""
    force, late = recording["force_BRA"], (recording.time > 1) & (recording.time < 2)
    return np.where(late, force[200], force)


EXCHANGED = measured(force_TRIlat=lambda r: r["force_BRA"], force_BRA=lambda r: r["force_TRIlat"])
# whose recording, what was done, and words of the sentence that must name it
WRONG = {
    "exchanged": ("hinge", EXCHANGED, "likelier with the forces of TRIlat and BRA exchanged"),
    "kilonewtons": ("hinge", measured(force_BRA=lambda r: r["force_BRA"] / 1e3), "force_BRA is never above"),
    "inverted": ("hinge", measured(angle_elbow=lambda r: -r["angle_elbow"]), "or inverted"),
    "hanging": ("hinge", measured(force_BRA=held), "force_BRA is the same number from 1 to"),
    "still": ("hinge", measured(angle_elbow=lambda r: 0 * r["angle_elbow"] + 1), "angle_elbow stands still"),
    "dead": ("hinge", measured(force_BRA=lambda r: 0 * r["force_BRA"]), "force_BRA is 0 throughout"),
    "degrees": ("hinge", measured(angle_elbow=lambda r: r["angle_elbow"] / 57.3), "angle_elbow in radians"),
    "heavy": ("hinge", other_masses(10.0), "masses 0.1 times as large"),
    "light": ("hinge", other_masses(0.1), "masses may be larger"),
    "F_max": ("dynamometer", other_muscle("muscle", "F_max", 0.4), "activation muscle is at a limit"),
    "l0": ("arm_smooth", other_muscle("BIClong", "optimal_fibre_length", 1.05), "fibre length of BIClong 5% smaller"),
    "slack": ("arm_smooth", other_muscle("BIClong", "tendon_slack_length", 1.02), "slack length of BIClong 2% smaller"),
    "arm exchanged": (
        "arm_random",
        measured(force_BRA=lambda r: r["force_TRIlong"], force_TRIlong=lambda r: r["force_BRA"]),
        "the forces of TRIlong and BRA exchanged",
    ),
}
QUICK = ("exchanged", "kilonewtons", "inverted", "hanging", "still", "dead")
# of the quick ones, that are told in so many samples
FEW = 800


def doubts(verdict: Verdict) -> str:
    return "\n".join(finding.sentence for finding in verdict.findings if finding.doubtful)


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n == "hinge" else pytest.mark.chaos) for n in RIGHT])
def test_the_right_recording_is_not_doubted(name: str) -> None:
    verdict = hillobs.verdict(*given(name, FEW if name == "hinge" else None))
    assert doubts(verdict) == ""
    assert verdict.quality == "good"
    subjects = [finding.subject for finding in verdict.findings]
    assert subjects == ["innovations", "form", "bias", "muscles", "untold"]
    assert json.loads(json.dumps(verdict.as_dict(), allow_nan=False))["quality"] == "good"


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in QUICK else pytest.mark.chaos) for n in WRONG])
def test_what_is_wrong_is_named(name: str) -> None:
    whose, change, words = WRONG[name]
    verdict = hillobs.verdict(*change(*given(whose, FEW if name in QUICK else None)))
    assert verdict.quality == "doubtful"
    assert words in doubts(verdict), doubts(verdict)


@pytest.mark.chaos
def test_muscles_with_the_same_moment_arms_cannot_be_told_apart() -> None:
    verdict = hillobs.verdict(*given("arm_random"))
    (untold,) = (finding.sentence for finding in verdict.findings if finding.subject == "untold")
    assert "which force is that of TRIlat and of TRImed" in untold


@pytest.mark.chaos
@pytest.mark.parametrize("seed", range(1000, 1008))
def test_right_recordings_that_are_drawn_are_not_doubted(seed: int) -> None:
    """With light links and heavy ones, activations that are smooth and that jump."""
    assert doubts(hillobs.verdict(*as_mechanism(drawn(seed, rates=(100.0, 200.0))))) == ""


def test_estimates_on_the_command_line_are_judged(tmp_path: Path, command) -> None:
    recording, _ = given("hinge", FEW)
    columns = {"time": recording.time, **recording.measured, "force_BRA": 0 * recording.time}
    rows = np.column_stack(list(columns.values()))
    np.savetxt(tmp_path / "x.csv", rows, delimiter=",", header=",".join(columns), comments="")
    asked = ("estimate", str(tmp_path / "x.csv"), "--mechanism", str(HINGE), "--observer", "kalman", "--no-figures")
    code, out, _ = command(*asked, "--json")
    assert code == 0
    assert json.loads(out)["verdict"]["quality"] == "doubtful"
    assert hillobs.load("estimates/estimates.nc").attrs["quality"] == "doubtful"
