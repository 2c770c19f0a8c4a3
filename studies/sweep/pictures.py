"""What the figures of a sweep are called, and the files that they go to."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..files.pictures import figure_paths
from .axes import Axes

CURVES, POINTS = "curves", "points"
# columns that a page has room for
MOST_COLUMNS = 5


def sweep_figure_paths(axes: Axes, observers: Sequence[str], folder: Path, stem: str) -> list[Path]:
    """The files that `save_sweep_figures` may write of such a sweep."""
    return figure_paths(folder, stem, possible(axes, observers))


def possible(axes: Axes, observers: Sequence[str]) -> list[str]:
    """The names of the figures that a sweep may have."""
    varied = len(axes.varied)
    if axes.kind == "grid" and varied == 1:
        return [CURVES]
    if axes.kind == "grid" and varied == 2:
        return [map_of(name) for name in observers]
    return [POINTS] if 0 < varied <= MOST_COLUMNS else []


def map_of(observer: str) -> str:
    """The name of an observer's map."""
    return f"map-{observer}"
