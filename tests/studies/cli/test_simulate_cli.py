"""`hillobs simulate` and the figures of its results: which files it writes, what it prints, what it leaves unsaid."""

import re
from pathlib import Path

import pytest

from command_line import CHANGED, SHORT
from places import contents


def test_without_an_argument_the_papers_two_are_run(command, tmp_path: Path) -> None:
    code, out, err = command("simulate", *SHORT, "--no-figures")
    assert (code, err) == (0, "")
    endings = ("-measures.csv", ".csv", ".nc")
    assert contents(tmp_path / "results").keys() == {
        f"paper-{kind}{CHANGED}{ending}" for kind in ("clean", "noisy") for ending in endings
    }
    assert "root mean square error over [0.1, 0.2]" in out
    assert "28.17 > 28.17446 does not hold" in out


def test_figures_of_an_earlier_run_go_with_it_but_for_those_that_were_changed(command, tmp_path: Path) -> None:
    run = ["simulate", "paper-clean", *SHORT, "--out", "here"]
    assert command(*run)[0] == 0
    changed = tmp_path / "here" / f"paper-clean{CHANGED}-inputs.png"
    changed.write_text("with my remarks")
    assert command(*run, "--no-figures")[0] == 0
    assert list((tmp_path / "here").glob("*.png")) == [changed]


def test_figures_are_written_and_drawn_again(command, tmp_path: Path) -> None:
    code, *_ = command("simulate", "paper-clean", *SHORT, "--out", "here")
    assert code == 0
    first = {path.name: path.read_bytes() for path in (tmp_path / "here").glob("*.p*")}
    assert len(first) == 5
    code, out, _ = command("figures", f"here/paper-clean{CHANGED}.nc", "--out", "again")
    assert (code, out) == (0, "written to again/: 5 figures as PNG\n")
    assert {path.name: path.read_bytes() for path in (tmp_path / "again").glob("*.p*")} == first


def test_only_the_observers_asked_for_run(command) -> None:
    code, out, _ = command(
        "simulate", "paper-noisy", *SHORT, "--no-figures", "--observer", "sliding_mode", "--seed", "4"
    )
    assert code == 0
    assert "seed 4" in out
    assert "SMO" in out
    assert "HGO" not in out


def test_a_changed_run_does_not_replace_the_run_as_shipped(command, tmp_path: Path) -> None:
    for changes in ([], ["--set", "high_gain.eps_h=0.2"], ["--observer", "high_gain"]):
        command("simulate", "paper-clean", "--no-figures", *changes)
    names = {path.name for path in (tmp_path / "results").glob("*.nc")}
    assert names == {"paper-clean.nc", "paper-clean,high_gain.eps_h=0.2.nc", "paper-clean,high_gain.nc"}
    many = [
        word for path in ("h11", "h12", "h13", "h21", "h22", "h31", "h32") for word in ("--set", f"high_gain.{path}=2")
    ]
    code, out, _ = command("simulate", "paper-clean", "--no-figures", *many)
    assert code == 0
    assert re.search(r"paper-clean,7 changes,[0-9a-f]{8}\.nc", out)


def test_two_scenarios_of_one_name_do_not_overwrite_each_other(command, tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "x.toml").write_text("duration = 0.1\n")
    code, out, err = command("simulate", "a/x.toml", "b/x.toml", "--no-figures")
    assert (code, out) == (2, "")
    assert "x" in err


def test_a_shown_scenario_says_nothing_of_numbers_that_nobody_touched(command, tmp_path: Path) -> None:
    _, text, _ = command("show", "activation")
    (tmp_path / "my.toml").write_text(text)
    assert "without effect" not in command("simulate", "my.toml", *SHORT, "--no-figures")[1]
    (tmp_path / "my.toml").write_text(text.replace("k_c = 0.0", "k_c = 5.0"))
    assert (
        "without effect while plant.drive = given: controller.k_c\n"
        in command("simulate", "my.toml", *SHORT, "--no-figures")[1]
    )


def test_a_number_that_nothing_takes_is_named(command) -> None:
    settings = [*SHORT, "--set", "plant.drive=given", "--set", "reference.offset=2.7", "--set", "plant.m=1.1"]
    code, out, _ = command("simulate", "paper-clean", *settings, "--no-figures")
    assert code == 0
    assert "without effect while plant.drive = given: reference.offset\n" in out
    assert "without effect" not in command("simulate", "challenge", *SHORT, "--no-figures")[1]


def test_a_short_run_says_nothing_of_conditions_it_cannot_check(command) -> None:
    code, out, _ = command("simulate", "paper-clean", "--set", "duration=0.01", "--set", "record=0.01", "--no-figures")
    assert code == 0
    code, out, _ = command(
        "simulate", "paper-clean", "--set", "duration=0.005", "--set", "record=0.005", "--no-figures"
    )
    assert code == 0
    assert "nan" not in out


def test_no_number_of_a_table_is_cut_in_a_narrow_terminal(command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    _, out, _ = command("simulate", "paper-noisy", *SHORT, "--no-figures")
    assert "…" not in out


def test_what_did_not_settle_keeps_its_column(command) -> None:
    _, out, _ = command("simulate", "paper-noisy", *SHORT, "--no-figures")
    table = out.partition("settling time")[2].splitlines()
    assert table[1].split() == ["x1", "x2", "x3", "x4", "Delta", "u1", "u2", "a1", "a2"]
    assert "–" in table[2]
