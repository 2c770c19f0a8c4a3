"""The report of an estimate: one file for a browser, to be read, printed and handed on."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence

import xarray as xr

from ....observers import label
from ...estimate.scores import SETTLED, Score
from .estimate import failures, notes, score_cells
from .web import image, listed, page, section, table

_SHEET = (
    "Measured above; below for each observer its estimates beside the truth, dashed where it is known, their errors, "
    "and the innovations: what the estimates leave unexplained of position and tendon lengths."
)


def estimate_page(dataset: xr.Dataset, scores: Sequence[Score], verdict: Sequence[str], sheet: bytes) -> bytes:
    """The page, UTF-8. verdict: sentences on how far the estimates can be trusted; sheet: the figure as PNG."""
    return page(f"Estimates from {dataset.attrs['source']}", _sections(dataset, scores, verdict, sheet))


def _sections(dataset: xr.Dataset, scores: Sequence[Score], verdict: Sequence[str], sheet: bytes) -> Iterator[str]:
    if first := [*failures(dataset), *verdict]:
        yield section("Verdict", listed(first))
    if scores:
        head, *rows = score_cells(scores)
        caption = f"Root mean square errors after {SETTLED:g} s, both muscles together"
        yield section("How far from the truth", table(rows, head, caption))
    yield section("Estimates", image(sheet, _SHEET))
    yield section("How they were made", listed(notes(dataset)))
    observers = dataset.observer.values.tolist()
    gains, steps = (json.loads(dataset.attrs[name]) for name in ("gains", "substeps"))
    yield section(
        "Observers",
        *(
            table(_paths({"steps from sample to sample": steps[name], **gains[name]}), caption=label(name))
            for name in observers
        ),
    )
    muscles, settings = json.loads(str(dataset.muscle_file.values)), json.loads(dataset.attrs["settings"])
    yield section("Muscles", table(_paths(muscles), caption="in SI", words_in=True))
    yield section("Settings", table(_paths(settings), words_in=True))
    versions = {**json.loads(dataset.attrs["versions"]), "library": dataset.attrs["library"]}
    yield section("Versions", table(versions.items(), words_in=True))


def _paths(content: Mapping[str, object], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Path and value of each leaf of nested tables; of a list of points, how many there are."""
    for name, value in content.items():
        if isinstance(value, dict):
            yield from _paths(value, f"{prefix}{name}.")
        else:
            yield prefix + name, f"{len(value)} points" if isinstance(value, list) else _plain(value)


def _plain(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
