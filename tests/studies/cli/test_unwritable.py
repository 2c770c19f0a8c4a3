"""A place that cannot be written to is a sentence, and nothing partial is left there."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from command_line import CHANGED, SHORT


@pytest.mark.parametrize("place", ["file", "file/below", os.devnull, "/dev/full", "/proc/nothing", "x" * 300])
def test_an_output_that_is_no_folder_is_a_sentence(place: str, command, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    code, out, err = command("simulate", *SHORT, "--no-figures", "--out", place)
    assert (code, out) == (2, "")
    assert err.startswith(f"hillobs: {place} cannot be written to: ")
    assert (tmp_path / "file").read_text() == "mine"


def test_an_output_that_is_a_file_is_called_one(command, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    err = command("simulate", *SHORT, "--no-figures", "--out", "file")[2]
    assert err == "hillobs: file cannot be written to: it is not a folder\n"


def test_a_folder_without_rights_is_a_sentence(tmp_path: Path) -> None:
    """As a user who may not write there; an administrator may write everywhere."""
    locked = tmp_path / "locked"
    locked.mkdir()
    locked.chmod(0o555)
    code = (
        "import os; from pathlib import Path; from hillobs.studies.files.writing import ResultError, writable_folder\n"
        "os.chdir('locked')\n"
        "if os.geteuid() == 0: os.setgid(65534); os.setuid(65534)\n"
        "try: writable_folder(Path('out'))\nexcept ResultError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.stdout == "out cannot be written to: Permission denied\n", done.stderr


def test_a_result_that_cannot_be_replaced_is_seen_before_the_run(command, tmp_path: Path) -> None:
    (tmp_path / "o" / f"paper-clean{CHANGED}.csv").mkdir(parents=True)
    code, _, err = command("simulate", "paper-clean", *SHORT, "--no-figures", "--out", "o")
    assert code == 2
    assert err.startswith(f"hillobs: o/paper-clean{CHANGED}.csv is there already, and not as hillobs wrote it")
    assert os.listdir(tmp_path / "o") == [f"paper-clean{CHANGED}.csv"]
