"""Figures as files, with our settings whatever the user's are."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import matplotlib
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from ..files.writing import write_whole
from . import style

# entries of a legend that a page is wide enough for
_COLUMNS = 5


def above(figure: Figure, handles: Sequence[Artist]) -> None:
    """One legend above all panels, in as few rows as the page needs, each as full as the others."""
    rows = -(-len(handles) // _COLUMNS)
    figure.legend(handles=list(handles), loc="outside upper center", ncols=-(-len(handles) // rows))


@contextmanager
def settings() -> Iterator[None]:
    """Our settings on top of matplotlib's own, whatever the user's are; gone afterwards."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(style.RC)
        yield


def write_figures(drawn: Mapping[str, Figure], folder: str | Path, stem: str) -> list[Path]:
    """Write figures as `STEM-KEY.png` and `.pdf`, without a date. ResultError if one cannot be written."""
    paths = []
    for key, figure in drawn.items():
        for kind, undated in (("png", {"Software": None}), ("pdf", {"CreationDate": None})):
            content = io.BytesIO()
            with settings():
                figure.savefig(content, format=kind, metadata=undated)
            figure.set_layout_engine("none")  # found once, it also holds for the second file
            paths.append(Path(folder) / f"{stem}-{key}.{kind}")
            write_whole(paths[-1], content.getvalue())
    return paths
