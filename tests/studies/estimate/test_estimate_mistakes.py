"""A user's mistake is one sentence, in Python and on the command line."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hillobs.observers import PAPER
from hillobs.studies.estimate.run import estimate
from hillobs.studies.files.errors import RecordingError, ScenarioError
from hillobs.studies.laboratory.recording import Recording
from places import RECORDINGS
from shipped_recording import MUSCLES, write_measured

pytestmark = pytest.mark.numerics

ARM = RECORDINGS / "arm.toml"


def test_what_cannot_be_is_a_sentence(short: Recording) -> None:
    with pytest.raises(
        ScenarioError, match=r"unknown observer 'luenberger'; there are high_gain, sliding_mode, adaptive"
    ):
        estimate(short, MUSCLES, ["high_gain", "luenberger"])
    with pytest.raises(ScenarioError, match="keep_every must be a whole number from 1 to 250,000,000, not 0"):
        estimate(short, MUSCLES, keep_every=0)
    still = dict.fromkeys(("position", "force_1", "force_2"), np.broadcast_to(0.1, 10**7))
    many = dataclasses.replace(short, time=np.arange(1e7), measured=still, true={})
    with pytest.raises(ScenarioError, match=r"10,000,000 samples make .* keep every 6th \(--every 6\) or fewer"):
        estimate(many, MUSCLES)
    for none in ([], (), 3):
        with pytest.raises(ScenarioError, match=r"observers must be one or more, not .*; left out they are high_gain"):
            estimate(short, MUSCLES, none)
    with pytest.raises(RecordingError, match="a recording is a file's name or one that was read, not 3"):
        estimate(3, MUSCLES)
    with pytest.raises(ScenarioError, match="muscles are a file's name or a pair that was read, not 3"):
        estimate(short, 3)
    assert estimate(short, MUSCLES).observer.values.tolist() == list(PAPER)
    assert estimate(short, MUSCLES, ["high_gain", "high_gain"]).sizes["observer"] == 1


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        ((), 2, "a recording needs either --muscles FILE.toml, a pair, or --mechanism FILE.toml"),
        (("--muscles", "nowhere.toml"), 2, "nowhere.toml: cannot be read: No such file or directory"),
        (("--muscles", "short.csv"), 2, "short.csv: not valid TOML"),
        (("--muscles", str(ARM)), 2, f"{ARM}: it has joints, so it is a mechanism: --mechanism, or read_mechanism"),
        (("--mechanism", str(MUSCLES)), 2, f"{MUSCLES}: it has a mass and no joints, so it is a pair: --muscles"),
        (("--muscles", str(MUSCLES), "--observer", "luenberger"), 2, "unknown observer 'luenberger'"),
        (("--muscles", str(MUSCLES), "--every", "1.5"), 2, "--every must be a whole number of at least 1, not '1.5'"),
        (("--muscles", str(MUSCLES), "--set", "high_gain.eps_h=fast"), 2, "high_gain.eps_h must be a number"),
        (("--muscles", str(MUSCLES), "--map", "position=x"), 2, "short.csv: position is mapped to 'x', which is not"),
        (
            ("--muscles", str(MUSCLES), "--map", "position=force_1"),
            2,
            "short.csv: column 'force_1 [N]': N is the unit of a force",
        ),
        (("--muscles", str(MUSCLES), "--map", "position=position[mm]"), 2, "short.csv: column 'position [m]'"),
        (("--muscles", str(MUSCLES), "--out", "short.csv"), 2, "short.csv cannot be written to: it is not a folder"),
        # unstable whatever the step
        (("--muscles", str(MUSCLES), "--set", "high_gain.h11=-300"), 1, "high_gain: x1_hat is not a number within ±"),
        (("--muscles", str(MUSCLES), "--set", "high_gain.h12=-1e9"), 2, "the gains of high_gain are too fast"),
    ],
)
def test_mistakes_on_the_command_line_are_one_sentence(
    arguments: tuple[str, ...], code: int, sentence: str, short: Recording, command: Callable[..., tuple[int, str, str]]
) -> None:
    write_measured(short, Path("short.csv"))
    exit_code, _, err = command("estimate", "short.csv", "--no-figures", *arguments)
    assert exit_code == code
    assert err.startswith(f"hillobs: {sentence}")
    assert err.count("\n") == 1
    # what failed is written all the same, and nothing else is
    assert Path("estimates", "estimates.nc").exists() == (code == 1)


def test_forces_in_kilonewtons_are_asked_about_and_have_no_band(
    short: Recording, command: Callable[..., tuple[int, str, str]]
) -> None:
    newtons = {name: short[name] / (1000 if name.startswith("force") else 1) for name in short.measured}
    write_measured(dataclasses.replace(short, measured=newtons), Path("short.csv"))
    _, out, _ = command("estimate", "short.csv", "--muscles", str(MUSCLES), "--observer", "high_gain", "--no-figures")
    assert "force_1 is never above 0.0004 F_max of its muscle: it may be in kN, or F_max is another" in out
    assert "how far the activations of HGO may be off cannot be told, since most of them are at a limit" in out
