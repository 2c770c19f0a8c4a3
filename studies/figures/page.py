"""Figures as files, with our settings whatever the user's are."""

from __future__ import annotations

import io
import itertools
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import matplotlib
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from ..files.pictures import PNG, figure_paths
from ..files.writing import refuse_overwriting, write_whole
from . import style

# entries of a legend that a page is wide enough for
_COLUMNS = 5
# how each kind of file is kept from saying when it was made
_UNDATED: Mapping[str, dict[str, None]] = {"png": {"Software": None}, "pdf": {"CreationDate": None}}


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


def write_figures(drawn: Mapping[str, Figure], folder: str | Path, stem: str, kinds: Sequence[str] = PNG) -> list[Path]:
    """Write figures as `STEM-KEY.KIND`, "png" or "pdf", without a date. ResultError if one cannot be written.

    If one is there that `refuse_overwriting` refuses, none is written.
    """
    paths = figure_paths(folder, stem, drawn, kinds)
    refuse_overwriting(paths)
    for path, (figure, kind) in zip(paths, itertools.product(drawn.values(), kinds), strict=True):
        write_whole(path, content(figure, kind))
    return paths


def content(figure: Figure, kind: str) -> bytes:
    """A figure as the bytes of a file, "png" or "pdf", without a date."""
    file = io.BytesIO()
    with settings(), warnings.catch_warnings():
        # words longer than the page, as only a forged result has: drawn over each other
        warnings.filterwarnings("ignore", "constrained_layout not applied", UserWarning)
        figure.savefig(file, format=kind, metadata=_UNDATED[kind])
    figure.set_layout_engine("none")  # found once, it also holds for the next file
    return file.getvalue()
