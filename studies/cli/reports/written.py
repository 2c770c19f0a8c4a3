"""Where what was written is."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .number import counted

_FIGURES = {".png": "PNG", ".pdf": "PDF"}


def written(paths: Sequence[Path]) -> str:
    """The folder and the files in it; figures are only counted."""
    names = [path.name for path in paths if path.suffix not in _FIGURES]
    if kinds := list(dict.fromkeys(path.suffix for path in paths if path.suffix in _FIGURES)):
        drawn = sum(path.suffix == kinds[0] for path in paths)
        names.append(f"{counted(drawn, 'figure')} as {' and '.join(_FIGURES[kind] for kind in kinds)}")
    return f"written to {paths[0].parent}/: {', '.join(names)}"
