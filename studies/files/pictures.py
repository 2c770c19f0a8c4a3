"""The files that figures go to: known without matplotlib, which takes as long to come as a run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

# a PDF takes as long to write as a run; who needs it draws again, `hillobs figures --pdf`
PNG, WITH_PDF = ("png",), ("png", "pdf")


def figure_paths(folder: str | Path, stem: str, keys: Iterable[str], kinds: Sequence[str] = PNG) -> list[Path]:
    """The files of the figures that `write_figures` writes, in its order."""
    return [Path(folder) / f"{stem}-{key}.{kind}" for key in keys for kind in kinds]
