"""Odd names and descriptions: a good file runs whatever it is called, and none controls the terminal."""

import os
import re
from pathlib import Path

import pytest

from command_line import CHANGED, SHORT
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.muscles import read_muscles
from places import RECORDINGS, contents

ODD_NAMES = ["a[/x].toml", "run[bold].toml", "-dash.toml", "sp ace.toml", "$(touch made).toml", "ü😀.toml", "...toml"]


@pytest.mark.parametrize("name", ODD_NAMES)
def test_a_good_file_with_an_odd_name_runs(name: str, command, tmp_path: Path) -> None:
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("duration = 0.1\nscore.start = 0.05\n")
    code, out, err = command("simulate", "--no-figures", "--out", "o", "--", name)
    assert (code, err) == (0, "")
    assert out.startswith(f"{path.stem}, seed 0")
    assert sorted(contents(tmp_path / "o")) == [f"{path.stem}{end}" for end in ("-measures.csv", ".csv", ".nc")]
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize(
    "name", ["red\x1b[31m.toml", "bell\a.toml", "back\r.toml", "\x9b31m.toml", os.fsdecode(b"\xff.toml")]
)
def test_a_name_cannot_send_control_characters_to_the_terminal(name: str, command, tmp_path: Path) -> None:
    (tmp_path / name).write_text("duration = 0.1\nscore.start = 0.05\n")
    code, out, err = command("simulate", "--no-figures", "--", name)
    assert code in (0, 2)
    assert (out + err).replace("\n", "").isprintable()


@pytest.mark.parametrize("character", ["\\u001b", "\\r", "\\u0007", "\\u009b", "\\u007f"])
def test_a_description_cannot_send_control_characters_to_the_terminal(character: str, command, tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text(f'description = "a{character}b"\nduration = 0.1\nscore.start = 0.05\n')
    code, out, err = command("simulate", "--no-figures", "x.toml")
    assert code in (0, 2)
    assert (out + err).replace("\n", "").isprintable()


def test_a_description_that_is_no_text_is_a_sentence(command, tmp_path: Path) -> None:
    """An argument in another encoding than the terminal's reaches Python as lone surrogates."""
    change = os.fsdecode(b"description=\xff")
    code, out, err = command("simulate", *SHORT, "--set", change, "--no-figures", "--out", str(tmp_path))
    assert (code, out) == (2, "")
    assert err == "hillobs: description must be a text of whole characters without \\0, not '\\udcff'\n"


# red letters, a bell, writing from right to left, markup of rich, mathematics of matplotlib
HOSTILE = "\x1b[31m\a\u202e[bold]$a_{"
CALLS = {
    "simulate": ("simulate", "{}.toml", "--no-figures"),
    "its figures": ("simulate", "{}.toml", "--set", "plant.m=1.1"),
    "sweep": ("sweep", "{}.toml", "--over", "high_gain.eps_h=0.1,0.2", "--no-figures", "--out", "{}.nc"),
    "observability": ("observability", "{}.toml"),
    "along a run": ("observability", "{}.toml", "--along"),
    "show": ("show", "{}.toml"),
    "figures": ("figures", "{}.nc"),
    "estimate": ("estimate", "{}\udcff.csv.gz", "--muscles", "{}-pair.toml", "--no-figures"),
    "a gain by hand": ("estimate", "{}\udcff.csv.gz", "--muscles", "{}-pair.toml", "--set", "{}\udcff=1"),
    "a column": ("estimate", "{}\udcff.csv.gz", "--muscles", "{}-pair.toml", "--map", "{}\udcff=x"),
    "a path": ("simulate", "--set", "{}\udcff=1"),
    "a sensor": ("observability", "--outputs", "{}\udcff"),
}


@pytest.mark.parametrize("call", CALLS)
def test_no_command_lets_the_words_of_others_reach_terminal_or_figure(call: str, command, tmp_path: Path) -> None:
    (tmp_path / f"{HOSTILE}.toml").write_text("duration = 0.1\nscore.start = 0.05\n")
    (tmp_path / f"{HOSTILE}-pair.toml").write_bytes((RECORDINGS / "dgf_smooth.toml").read_bytes())
    (tmp_path / f"{HOSTILE}\udcff.csv.gz").write_bytes((RECORDINGS / "dgf_smooth_noisy.csv.gz").read_bytes())
    if call == "figures":
        command("simulate", "paper-clean", *SHORT, "--no-figures", "--out", ".")
        (tmp_path / f"paper-clean{CHANGED}.nc").rename(tmp_path / f"{HOSTILE}.nc")
    code, out, err = command(*(word.format(HOSTILE) for word in CALLS[call]))
    assert code in (0, 1, 2)
    assert (out + err).replace("\n", "").isprintable()
    assert err.count("\n") <= 1


def test_the_description_of_a_pair_can_be_stored_or_is_refused(tmp_path: Path) -> None:
    pair = (RECORDINGS / "dgf_smooth.toml").read_text()
    path = tmp_path / "pair.toml"
    path.write_text(re.sub("(?m)^description = .*", r'description = "bell \\u0007"', pair))
    assert read_muscles(path).description == "bell \a"
    path.write_text(re.sub("(?m)^description = .*", r'description = "half \\u0000"', pair))
    with pytest.raises(ScenarioError, match="description must be a text of whole characters"):
        read_muscles(path)
