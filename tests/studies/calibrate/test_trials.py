"""Files of trials: what they say, and that a mistake in one is a sentence."""

import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from held_trials import MAXIMAL, PAIR, guessed, noisy, trial
from hillobs.studies.calibrate.run import calibrate
from hillobs.studies.calibrate.trial import Trial, read_trial
from hillobs.studies.cli.main import commands
from hillobs.studies.files.errors import RecordingError, ScenarioError
from hillobs.studies.files.toml import toml_document
from hillobs.studies.laboratory.mechanisms.reading import mechanism_of
from hillobs.studies.laboratory.muscles import muscle_file
from hillobs.studies.laboratory.recording import Recording
from hillobs.studies.laboratory.subject import pair_subject
from random_recordings import Drawn, as_mechanism

MUSCLES = pair_subject(PAIR)
RECORDING = 'recording = "five.csv"\n'


def write_recording(recording: Recording, path: Path, more: str = "", column: np.ndarray | None = None) -> None:
    names = ["time", "position", "force_1", "force_2", *([more] if more else [])]
    columns = [recording.time, *recording.measured.values(), *([] if column is None else [column])]
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=",".join(names), comments="", fmt="%.9g")


@pytest.fixture
def desk(tmp_path: Path, five: Recording, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with `five.csv`, in which `drive` is the activation of muscle 1, and `guess.toml`."""
    write_recording(noisy(five, 1), tmp_path / "five.csv", "drive", np.ones(len(five)))
    (tmp_path / "guess.toml").write_text(toml_document(muscle_file(guessed(1))), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(text: str, name: str = "trial.toml") -> Path:
    path = Path(name)
    path.write_text(text, encoding="utf-8")
    return path


def test_an_activation_is_a_number_or_a_column_with_or_without_a_deviation(desk: Path) -> None:
    for given, sd in (
        ("1.0", 0.02),
        ("{ value = 1.0, sd = 0.01 }", 0.01),
        ('"drive"', 0.02),
        ('{ column = "drive", sd = 0 }', 0.0),
    ):
        read = read_trial(written(f"{RECORDING}[activation]\nmuscle1 = {given}\nmuscle2 = 0\n"), MUSCLES)
        assert read.sds == {"muscle1": sd, "muscle2": 0.003}
        assert np.all(read.activation["muscle1"] == 1)
    assert read.activation["muscle2"] == 0


def test_columns_are_named_as_those_of_estimate(desk: Path, five: Recording) -> None:
    lines = Path("five.csv").read_text(encoding="utf-8").splitlines()
    written("\n".join([lines[0].replace("position", "block"), *lines[1:]]), "five.csv")
    columns = '[columns]\nposition = { column = "block", unit = "mm" }\n'
    read = read_trial(written(f"{RECORDING}[activation]\nmuscle1 = 1\n{columns}"), MUSCLES)
    assert read.recording["position"] == pytest.approx(noisy(five, 1)["position"] / 1e3, rel=1e-8)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "recording, activation are missing"),
        (RECORDING, "activation is missing"),
        (f"{RECORDING}activation = 1\n", r"activation must be a table, \[activation\], not 1"),
        (f"{RECORDING}[activation]\n", "activation must name a muscle whose activation is known"),
        (f"{RECORDING}[activation]\nbiceps = 1\n", "unknown key 'activation.biceps'; the nearest are"),
        (f"{RECORDING}[activation]\nmuscle1 = 1.2\n", "activation.muscle1 must be at most 1, not 1.2"),
        (f"{RECORDING}[activation]\nmuscle1 = nan\n", "activation.muscle1 must be a finite number, not nan"),
        (f"{RECORDING}[activation]\nmuscle1 = true\n", "activation.muscle1 must be a number, not true"),
        (
            f"{RECORDING}[activation]\nmuscle1 = {{ value = 1 }}\n",
            r"muscle1 must be a number, a column, or \{ value = …",
        ),
        (f"{RECORDING}[activation]\nmuscle1 = {{ value = 1, sd = -1 }}\n", "sd of muscle1 must be at least 0, not -1"),
        (f'{RECORDING}[activation]\nmuscle1 = "emg"\n', "activation_1 is mapped to 'emg', which is not there"),
        (f'{RECORDING}[activation]\nmuscle1 = "force_1"\n', "force_1"),
        (
            f"{RECORDING}between = [3, 1]\n[activation]\nmuscle1 = 1\n",
            "between must be two times in s, the earlier one",
        ),
        (f"{RECORDING}between = 3\n[activation]\nmuscle1 = 1\n", "between must be two times in s, such as"),
        (f"{RECORDING}length = 3\n[activation]\nmuscle1 = 1\n", "unknown key 'length'"),
        ('recording = "no.csv"\n[activation]\nmuscle1 = 1\n', "no.csv: cannot be read: No such file"),
        ("recording = 3\n[activation]\nmuscle1 = 1\n", "recording must be a text, not 3"),
        (f"{RECORDING}[activation]\nmuscle1 = 1\n[columns]\nposition = 3\n", "columns.position must be"),
        (
            f'{RECORDING}[activation]\nmuscle1 = 1\n[columns]\nposition = "x"\n',
            "position is mapped to 'x', which is not",
        ),
    ],
)
def test_a_mistake_in_a_file_is_a_sentence(text: str, sentence: str, desk: Path) -> None:
    with pytest.raises((ScenarioError, RecordingError), match=sentence):
        read_trial(written(text), MUSCLES)


def test_a_column_of_activations_must_be_there_at_all_times_and_within_its_bounds(desk: Path, five: Recording) -> None:
    text = f'{RECORDING}[activation]\nmuscle1 = "drive"\n'
    for value, sentence in ((np.nan, "five.csv: drive has no value in row 12"), (1.5, "it is 1.5 in row 12")):
        drive = np.ones(len(five))
        drive[10] = value
        write_recording(noisy(five, 1), Path("five.csv"), "drive", drive)
        with pytest.raises((ScenarioError, RecordingError), match=sentence):
            read_trial(written(text), MUSCLES)


def test_what_no_trials_can_be_is_a_sentence(five: Recording) -> None:
    seen, start = noisy(five, 1), guessed(1)
    once = trial(seen, MAXIMAL)
    for trials, sentence in (
        ([], r"trials must be a list of one or more, not \[\]"),
        ("five.toml", "trials must be a list of one or more, not 'five.toml'"),
        ([3], "a trial is a file's name or one that was read, not 3"),
        ([once, once], "five.csv is given twice for muscle1; what is measured once counts once"),
        ([once, trial(seen, {"muscle1": 0.0})], "five.csv is given twice for muscle1"),
        ([Trial(seen, {"biceps": 1.0})], "'biceps' is no muscle of these; there are muscle1, muscle2"),
        ([trial(seen.part(slice(120, 290)), MAXIMAL)], "muscle1 is known for .* s; a trial takes 1 s or more"),
        ([Trial(seen, MAXIMAL, between=(20.0, 30.0))], "no sample lies between 20 and 30 s; it has 0 to 4.995 s"),
        ([trial(seen.part(slice(0, 30)), MAXIMAL)], "Kalman filter finds its densities in 50 or more"),
    ):
        with pytest.raises((ScenarioError, RecordingError), match=sentence):
            calibrate(trials, start)


def test_without_scipy_it_says_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    with pytest.raises(ScenarioError, match=r"calibration needs SciPy: pip install 'hillobs\[calibrate\]'"):
        calibrate(["trial.toml"], guessed(1))


def test_both_halves_of_a_recording_are_two_trials(five: Recording) -> None:
    seen = noisy(five, 1)
    halves = [Trial(seen, MAXIMAL, {"muscle1": 0.0}, part) for part in ((0.0, 2.4), (2.6, 5.0))]
    assert len(calibrate(halves, guessed(1)).misfits) == 2


def test_one_length_tells_nothing(five: Recording) -> None:
    still = noisy(five, 1).part(slice(0, 160))
    with pytest.raises(ScenarioError, match=r"the trials of muscle1 are at one length, 0\.27\d* m give or take"):
        calibrate([trial(still, MAXIMAL)], guessed(1))


def test_trials_that_contradict_each_other_are_refused(passive: Recording, three: Recording) -> None:
    """A contraction with 0.6 of the force is one of 0.6, whatever the file says."""
    seen = noisy(three, 2)
    weak = seen.remeasured(force_1=seen["force_1"] * 0.6)
    trials = [trial(noisy(passive, 1), {"muscle1": 0.0}), trial(noisy(three, 3), MAXIMAL), trial(weak, MAXIMAL)]
    with pytest.raises(ScenarioError, match=r"the trials of muscle1 contradict each other: each fits alone"):
        calibrate(trials, guessed(1))


def test_the_command_writes_muscles_that_estimate_takes(desk: Path) -> None:
    written(f"{RECORDING}[activation]\nmuscle1 = {{ value = 1, sd = 0 }}\n")
    done = CliRunner().invoke(commands, ["calibrate", "trial.toml", "--muscles", "guess.toml"])
    assert done.exit_code == 0, done.output
    assert "optimal_fibre_length" in done.output
    assert "written to ./: calibrated.toml" in done.output
    given = ["estimate", "five.csv", "--muscles", "calibrated.toml", "--observer", "high_gain", "--no-figures"]
    done = CliRunner().invoke(commands, given)
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("trial.toml",), "a recording needs either --muscles FILE.toml, a pair, or --mechanism FILE.toml"),
        (
            ("trial.toml", "--muscles", "guess.toml", "--out", "found.txt"),
            "--out must be a .toml file, not 'found.txt'",
        ),
        (("trial.toml", "--muscles", "guess.toml", "--out", "guess.toml"), "guess.toml is there already"),
        (("five.csv", "--muscles", "guess.toml"), "five.csv: not valid TOML"),
        (("trial.toml", "trial.toml", "--muscles", "guess.toml"), "five.csv is given twice for muscle1"),
    ],
)
def test_a_mistake_on_the_command_line_is_a_sentence(arguments: tuple[str, ...], sentence: str, desk: Path) -> None:
    written(f"{RECORDING}[activation]\nmuscle1 = 1\n")
    done = CliRunner().invoke(commands, ["calibrate", *arguments])
    assert done.exit_code == 2
    assert sentence in done.stderr
    assert not Path("calibrated.toml").exists()


def test_a_muscle_of_a_mechanism_is_calibrated_as_that_of_a_pair(five: Recording) -> None:
    """A block between two muscles. Its joint is filtered apart from the tendons, so noise leaves something else."""
    seen, start = noisy(five, 1), guessed(1)
    recording, mechanism = as_mechanism(Drawn(0, "", start, seen))
    of_pair, found = calibrate([trial(seen, MAXIMAL)], start), calibrate([trial(recording, {"A": 1.0})], mechanism)
    for one, other in zip(of_pair.numbers, found.numbers, strict=True):
        assert (one.name, "A") == (other.name, other.muscle)
        assert abs(one.value - other.value) < 2 * one.sd, one.name
    assert mechanism_of(tomllib.loads(found.toml), None).muscles["A"].sds == found.muscles.muscles["A"].sds
