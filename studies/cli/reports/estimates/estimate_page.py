"""The report of an estimate: one file for a browser, to be read, printed and handed on."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import cast

import xarray as xr

from .....model.symbols import MUSCLES
from ....estimate.bands.doubt import stated
from ....estimate.scores import SETTLED, Score
from ..web import image, listed, page, section, table
from .estimate import failures, notes, score_cells

# as long as an inertia
_VECTOR = 6
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
        caption = f"Root mean square errors after {SETTLED:g} s, {_together(dataset)}"
        yield section("How far from the truth", table(rows, head, caption))
    yield section("Estimates", image(sheet, _SHEET))
    yield section("How they were made", listed(notes(dataset)))
    yield section("Muscles", *_muscles(json.loads(str(dataset.muscle_file.values))))
    settings, doubt = (json.loads(dataset.attrs[name]) for name in ("settings", "doubt"))
    yield section(
        "Settings",
        table(_rows(settings), words_in=True),
        *(
            [table(stated(doubt).items(), caption="Standard deviations of numbers in doubt", words_in=True)]
            if doubt
            else []
        ),
    )
    versions = {**json.loads(dataset.attrs["versions"]), "library": dataset.attrs["library"]}
    yield section("Versions", table(_rows(versions), words_in=True))


def _muscles(content: dict[str, object]) -> Iterator[str]:
    """What the muscles share, and a column for each; `content` is that of a file of muscles or of a mechanism."""
    tables = content.pop("muscles") if "muscles" in content else {name: content.pop(name) for name in MUSCLES}
    each = {name: dict(_rows(own)) for name, own in cast(Mapping[str, object], tables).items()}
    yield table(_rows(content), caption="in SI", words_in=True)
    names = dict.fromkeys(name for muscle in each.values() for name in muscle)
    yield table([(name, *(muscle.get(name, "–") for muscle in each.values())) for name in names], ["", *each])


def _together(dataset: xr.Dataset) -> str:
    return "both muscles together" if dataset.sizes["muscle"] == len(MUSCLES) else "all muscles together"


def _rows(content: object, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Path and value of each leaf of nested tables; of a list of points, how many there are."""
    for name, value in content.items() if isinstance(content, dict) else ():
        if isinstance(value, dict):
            yield from _rows(value, f"{prefix}{name}.")
        else:
            yield prefix + name, _listed(value) if isinstance(value, list) else _plain(value)


def _listed(values: list[object]) -> str:
    """A vector in full, of longer lists how many there are."""
    if len(values) > _VECTOR or any(isinstance(value, list) for value in values):
        return f"{len(values)} {'points' if isinstance(values[0], list) else 'numbers'}"
    return ", ".join(map(_plain, values))


def _plain(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
