"""Figures do not depend on what the user's matplotlib is set to, nor on whether that can be read."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from hillobs.studies.figures.page import content, settings

DRAW = """
import io, os
from hillobs.studies.cli.shell.terminal import user_errors
with user_errors():
    from hillobs.studies.figures.page import Figure, settings
    with settings():
        figure = Figure()
        figure.add_subplot().plot([0, 1], [1, 0])
        content = io.BytesIO()
        figure.savefig(content, format="pdf", metadata={"CreationDate": None})
    print(len(content.getvalue()), os.environ.get("MPLBACKEND"), os.environ.get("MATPLOTLIBRC"))
"""
BROKEN, UNREADABLE = b"backend: nonsense\nlines.linewidth: many\nno colon\n", b"\xff\xfe\x00"


def drawn(folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    plain = {name: value for name, value in os.environ.items() if not name.startswith(("MPL", "MATPLOTLIB"))}
    command = [sys.executable, "-c", DRAW]
    return subprocess.run(command, cwd=folder, env=plain | environment, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def size(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Bytes of the figure without any settings."""
    return drawn(tmp_path_factory.mktemp("plain")).stdout.split()[0]


@pytest.mark.parametrize("backend", ["nonsense", "tkagg"])
def test_the_backend_of_the_user_is_not_asked_for(backend: str, size: str, tmp_path: Path) -> None:
    done = drawn(tmp_path, MPLBACKEND=backend)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{size} {backend} None\n", "")


@pytest.mark.parametrize("content", [BROKEN, UNREADABLE], ids=["broken", "unreadable"])
def test_the_settings_of_the_user_are_not_read(content: bytes, size: str, tmp_path: Path) -> None:
    path = tmp_path / "settings"
    path.write_bytes(content)
    done = drawn(tmp_path, MATPLOTLIBRC=str(path))
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{size} None {path}\n", "")


def test_a_folder_for_fonts_that_cannot_be_made_is_no_matter(size: str, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    done = drawn(tmp_path, MPLCONFIGDIR=str(tmp_path / "file"))
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{size} None None\n", "")


def test_settings_in_the_current_folder_that_cannot_be_read_are_a_sentence(size: str, tmp_path: Path) -> None:
    """matplotlib looks there before all else."""
    (tmp_path / "matplotlibrc").write_bytes(BROKEN)
    assert drawn(tmp_path).stdout == f"{size} None None\n"
    (tmp_path / "matplotlibrc").write_bytes(UNREADABLE)
    done = drawn(tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("hillobs: matplotlib cannot be loaded: ")
    assert done.stderr.endswith("; is ./matplotlibrc broken?\n")


def test_words_longer_than_the_page_are_drawn_without_a_word_of_the_library() -> None:
    """Warnings are errors in these tests."""
    with settings():
        figure = Figure(figsize=(2, 1), layout="constrained")
        figure.add_subplot().set_yticks([0], ["long" * 100])
    assert content(figure, "png").startswith(b"\x89PNG")
