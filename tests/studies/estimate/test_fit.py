"""`hillobs fit` finds numbers of the Kalman filter that `estimate` takes, and says what it needs."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import hillobs
from hillobs.studies.laboratory.recording import Recording
from places import DATA
from shipped_recording import HINGE, MUSCLES, write_measured

pytestmark = pytest.mark.numerics

Command = Callable[..., tuple[int, str, str]]
OF_KALMAN = ("--muscles", str(MUSCLES), "--observer", "kalman", "--form", "u", "--no-figures", "--no-verdict")


@pytest.fixture
def recorded(command: Command, short: Recording) -> Command:
    """The command line in a folder with a recording."""
    write_measured(short, Path("short.csv"))
    return command


def test_what_is_found_in_a_recording_is_taken_by_estimate(recorded: Command, short: Recording) -> None:
    code, out, err = recorded("fit", "short.csv", "--muscles", str(MUSCLES))
    assert (code, err) == (0, "")
    assert "fitted-short.csv.toml" in out
    path = Path("results", "fitted-short.csv.toml")
    assert "--observer kalman --set THIS_FILE" in path.read_text()
    assert recorded("estimate", "short.csv", *OF_KALMAN, "--set", str(path))[::2] == (0, "")
    given = hillobs.load("estimates/estimates.nc")
    found = hillobs.estimate(short, MUSCLES, "kalman", form="u")
    for name in ("gains", "numbers"):
        assert given.attrs[name] == found.attrs[name]
    np.testing.assert_array_equal(given.activation_hat, found.activation_hat)
    # what comes later counts
    changed = ("--set", str(path), "--set", "kalman.s_D=0.5")
    assert recorded("estimate", "short.csv", *OF_KALMAN, *changed)[::2] == (0, "")
    assert '"kalman.s_D": 0.5' in hillobs.load("estimates/estimates.nc").attrs["gains"]


def test_what_is_found_in_a_mechanism_is_taken_by_estimate(command: Command) -> None:
    recording = DATA / "hinge_pair_noisy.csv.gz"
    code, out, err = command("fit", str(recording), "--mechanism", str(HINGE))
    assert (code, err) == (0, "")
    assert "elbow Δ 3" in out
    (path,) = Path("results").glob("fitted-*.toml")
    assert "--mechanism FILE.toml --observer kalman --set THIS_FILE" in path.read_text()
    of_hinge = ("--mechanism", str(HINGE), "--observer", "kalman", "--form", "u", "--no-figures", "--no-verdict")
    assert command("estimate", str(recording), *of_hinge, "--set", str(path))[::2] == (0, "")
    given, found = hillobs.load("estimates/estimates.nc"), hillobs.estimate(recording, HINGE, "kalman", form="u")
    assert given.attrs["gains"] == found.attrs["gains"]
    np.testing.assert_array_equal(given.activation_hat, found.activation_hat)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ("fit", "short.csv"),
            "'short.csv': a recording needs its muscles (--muscles) or mechanism (--mechanism) to be followed",
        ),
        (
            ("fit", "paper-clean", "--map", "position=x"),
            "a mapping (--map) names columns of a recording, and a scenario",
        ),
        (("fit", "paper-nosy"), "unknown scenario 'paper-nosy'; there are paper-clean"),
        (("estimate", "short.csv", *OF_KALMAN, "--set", "none.toml"), "none.toml: cannot be read: No such file"),
        (("estimate", "short.csv", *OF_KALMAN, "--set", "base.toml"), "base.toml: it has a base, so it is a scenario"),
        (("estimate", "short.csv", *OF_KALMAN, "--set", "list.toml"), "kalman.s_D must be a number, not [1]"),
        (("estimate", "short.csv", *OF_KALMAN, "--set", "twice.toml"), "twice.toml: not valid TOML"),
    ],
)
def test_what_is_missing_is_one_sentence(arguments: tuple[str, ...], sentence: str, recorded: Command) -> None:
    Path("base.toml").write_text('base = "paper-noisy"\nkalman.s_D = 0.1\n')
    Path("list.toml").write_text("kalman.s_D = [1]\n")
    Path("twice.toml").write_text("kalman.s_D = 1\nkalman.s_D = 2\n")
    code, _, err = recorded(*arguments)
    assert code == 2
    assert err.startswith(f"hillobs: {sentence}")
    assert err.count("\n") == 1
