"""Odd names and descriptions: a good file runs whatever it is called, and none controls the terminal."""

import os
from pathlib import Path

import pytest

from command_line import SHORT
from places import contents

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
