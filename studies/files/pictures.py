"""The files that figures go to: known without matplotlib, which takes as long to come as a run."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

# each figure in these kinds of files
KINDS = ("png", "pdf")


def figure_paths(folder: str | Path, stem: str, keys: Iterable[str]) -> list[Path]:
    """The files of the figures that `write_figures` writes, in its order."""
    return [Path(folder) / f"{stem}-{key}.{kind}" for key in keys for kind in KINDS]
