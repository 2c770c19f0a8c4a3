"""Exit code 1: what failed is named with its cause, has no measures, and leaves the others as they were."""

from pathlib import Path

import pytest

from command_line import SHORT


def measures_in(folder: Path) -> str:
    """The measures of the one run in a folder."""
    (path,) = folder.glob("*-measures.csv")
    return path.read_text()


def test_an_observer_that_fails_is_named_and_the_others_are_kept(command, tmp_path: Path) -> None:
    settings = ["--set", "sliding_mode.tau_s=1e-5", "--set", "duration=2", "--set", "score.start=1"]
    code, out, err = command("simulate", "paper-noisy", *settings, "--no-figures")
    assert code == 1
    assert err.startswith("hillobs: sliding_mode: ")
    assert "is not a number within ±" in err
    assert " at τ = " in err
    assert "HGO" in out
    text = measures_in(tmp_path / "results")
    assert "high_gain,x2,0.00" in text
    assert "sliding_mode,x2,,,,," in text


def test_a_mass_out_of_reach_is_named(command) -> None:
    far = ["--set", "initial.x2=-40", "--set", "duration=2", "--set", "score.start=1"]
    code, _, err = command("simulate", "paper-clean", *far, "--no-figures")
    assert code == 1
    assert err.startswith("hillobs: the plant: the tendon length x3 reached 0 at τ = 0.0")


NUMERICAL = {
    "adaptive_sliding_mode": ["--set", "adaptive_sliding_mode.tau_a=1e-5"],
    "sliding_mode": ["--set", "sliding_mode.tau_s=1e-5"],
    "high_gain": ["--set", "high_gain.eps_h=1e-25"],
}


@pytest.mark.parametrize("observer", NUMERICAL)
def test_each_observer_that_fails_leaves_the_others_as_they_were(observer: str, command, tmp_path: Path) -> None:
    command("simulate", "paper-noisy", *SHORT, "--no-figures", "--out", "good")
    code, _, err = command("simulate", "paper-noisy", *SHORT, "--no-figures", "--out", "bad", *NUMERICAL[observer])
    assert code == 1
    assert err.startswith(f"hillobs: {observer}: ")
    assert err.count("\n") == 1
    rows = [measures_in(tmp_path / f).splitlines() for f in ("good", "bad")]
    for good, bad in zip(*rows, strict=True):
        if f",{observer}," in good:
            assert bad.endswith(",,,,,"), bad
        else:
            assert good == bad


def test_an_unstable_gain_is_not_blamed_on_the_step(command) -> None:
    """h11 < 0 is unstable for every step; its gain condition is violated and says so."""
    run = ["simulate", "paper-clean", "--set", "high_gain.h11=-5", "--observer", "high_gain", "--no-figures"]
    code, out, err = command(*run)
    assert code == 1
    assert "gain condition of HGO: h11 > 0" in out or "h₁₁" in out
    assert "gain" in err
    assert "step" not in err


def test_a_plant_outside_its_domain_is_named_and_has_no_measures(command, tmp_path: Path) -> None:
    far = ["--set", "plant.C=2", *SHORT]
    code, out, err = command("simulate", "paper-clean", *far, "--no-figures")
    assert code == 1
    assert err.startswith("hillobs: the plant: it starts outside its domain, the fibre length L_C2")
    text = measures_in(tmp_path / "results").splitlines()[1:]
    assert all(row.endswith(",,,,,") for row in text)
    assert "nan" not in out


def test_a_fibre_that_reaches_0_on_the_way_is_named(command, tmp_path: Path) -> None:
    pulse = ["pulse1.amplitude=5", "pulse1.start=0.1", "pulse1.stop=1", "duration=1", "score.start=0.05"]
    code, out, err = command("simulate", "paper-clean", *[x for p in pulse for x in ("--set", p)], "--no-figures")
    assert code == 1
    assert err.startswith("hillobs: the plant: the fibre length L_C1 reached 0 at τ = 0.")
    assert "was slack" not in out
    assert all(row.endswith(",,,,,") for row in measures_in(tmp_path / "results").split()[1:])
