"""Texts that follow from the code alone are made once, and are those that would be made."""

from pathlib import Path

import pytest

from command_line import in_a_process
from hillobs.studies.cli.reports.listing import listing
from hillobs.studies.files import kept
from hillobs.studies.files.kept import kept_text
from hillobs.studies.scenarios.show import show


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, of code that is as old as the process."""
    monkeypatch.setenv("HILLOBS_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(kept, "own_code", lambda *packages: "code")
    return tmp_path / "cache"


def never() -> str:
    raise AssertionError("made again")


def test_a_text_is_made_once(folder: Path) -> None:
    assert kept_text("one", lambda: "α\n") == "α\n"
    assert kept_text("one", never) == "α\n"
    assert kept_text("two", lambda: "β") == "β"


def test_other_code_makes_it_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept_text("one", lambda: "old")
    monkeypatch.setattr(kept, "own_code", lambda *packages: "other code")
    assert kept_text("one", lambda: "new") == "new"
    monkeypatch.setattr(kept, "own_code", lambda *packages: "")
    assert kept_text("one", lambda: "too new to be kept") == "too new to be kept"


def test_a_damaged_one_is_made_again(folder: Path) -> None:
    kept_text("one", lambda: "whole")
    (file,) = folder.glob("*.kept")
    file.write_bytes(file.read_bytes()[:-1])
    assert kept_text("one", lambda: "whole") == "whole"
    assert kept_text("one", never) == "whole"


def test_a_cache_that_cannot_be_used_is_not_spoken_of(folder: Path) -> None:
    """Warnings are errors here."""
    folder.mkdir()
    folder.chmod(0o777)
    assert kept_text("one", lambda: "text") == "text"
    assert not list(folder.iterdir())


KEPT = """
import sys
from hillobs.codegen import own_code
own_code._IMPORTED += 1000
from hillobs.__main__ import main
try:
    main()
finally:
    sys.stderr.write(f"CasADi: {'casadi' in sys.modules}")
"""


@pytest.mark.parametrize(
    ("words", "text"), [(["list"], lambda: "\n".join(listing("all"))), (["show", "slack"], lambda: show("slack")[:-1])]
)
def test_what_commands_print_is_what_would_be_made_and_takes_no_casadi(words, text, tmp_path: Path) -> None:
    runs = [in_a_process("-c", KEPT, *words, HILLOBS_CACHE=str(tmp_path / "cache")) for _ in range(2)]
    assert [run.stderr for run in runs] == ["CasADi: True", "CasADi: False"]
    assert runs[0].stdout == runs[1].stdout == f"{text()}\n"


def test_a_users_file_is_read_each_time(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    for mass in (1.5, 2.5):
        file.write_text(f'base = "paper-clean"\n[plant]\nm = {mass}\n')
        done = in_a_process("-c", KEPT, "show", str(file), HILLOBS_CACHE=str(tmp_path / "cache"))
        assert f"\nm = {mass} " in done.stdout
