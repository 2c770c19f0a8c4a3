"""The league as tables of Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import xarray as xr

from ....observers import label
from ...league.cells import CELLS
from ...league.claims import Claim
from ...league.closed import SETTLED
from ...league.gains import SETS
from ...league.play import Entry, Played
from ...scenarios.prepare import BASELINE
from ...sweep.optimum import SPREAD
from .number import number

# behind an error whose observer breaks a condition of its theorem there, or failed in some runs
_BROKEN, _FAILED = "†", "✗"


def home_table(
    played: Played, entries: Sequence[Entry], lines: xr.DataArray, cost: Mapping[str, float]
) -> Iterator[str]:
    """Each entry in the first cell: median errors with half their spread, and what a step costs."""
    home = played.errors.isel(cell=0)
    quantities = home.quantity.values.tolist()
    yield from _head(["", *quantities, "ns per step"])
    for entry in entries:
        cells = [_median_and_spread(home.sel(entry=str(entry), quantity=quantity)) for quantity in quantities]
        name = f"{entry}{_mark(played, str(entry), CELLS[0].name)}"
        yield _row([name, *cells, number(cost[entry.observer])])
    yield _row([BASELINE, *(_median_and_spread(home.sel(entry=BASELINE, quantity=q)) for q in quantities), ""])
    for line in lines.line.values.tolist():
        yield _row([f"*{line}*", *(_whole(float(lines.sel(line=line, quantity=q).median())) for q in quantities), ""])


def cells_table(played: Played, quantity: str) -> Iterator[str]:
    """Each entry in each cell: the median error of a quantity."""
    yield from _head([quantity, *(cell.name for cell in CELLS)])
    for name in played.errors.entry.values.tolist():
        row = [name]
        for cell in CELLS:
            errors = played.errors.sel(entry=name, cell=cell.name, quantity=quantity).values
            failed = int(np.isnan(errors).sum())
            median = _whole(float(np.median(np.where(np.isnan(errors), np.inf, errors))))
            row.append(f"{median}{_mark(played, name, cell.name)}{f' {_FAILED}{failed}' if failed else ''}")
        yield _row(row)


def arm_table(arm: xr.DataArray) -> Iterator[str]:
    """Each observer of the arm: median errors by kind."""
    kinds = arm["quantity"].values.tolist()
    yield from _head(["", *kinds])
    for name in arm.observer.values.tolist():
        of = arm.sel(observer=name)
        yield _row([label(name), *(_median_and_spread(of.sel(quantity=kind)) for kind in kinds)])


def closed_table(closed: xr.DataArray) -> Iterator[str]:
    """What is tracked, by whose estimates."""
    yield from _head(["controller sees", f"x₁ − r, RMS from τ = {SETTLED:g} on", "worst seed"])
    for name in closed.entry.values.tolist():
        of = closed.sel(entry=name)
        yield _row([name, _whole(float(of.median())), _whole(float(of.max(skipna=False)))])


def claims_table(claims: Sequence[Claim]) -> Iterator[str]:
    """The paper's claims."""
    yield from _head(["the paper says", "", "measured"])
    for claim in claims:
        yield _row([claim.words, f"**{claim.verdict}**", claim.evidence])


def conditions_list(played: Played) -> Iterator[str]:
    """Who breaks which condition where."""
    by_sentence: dict[tuple[str, str], list[str]] = {}
    for (entry, cell), sentences in played.violated.items():
        for sentence in sentences:
            by_sentence.setdefault((entry, sentence.removesuffix(" does not hold here")), []).append(cell)
    for (entry, condition), cells in by_sentence.items():
        where = "everywhere" if len(cells) == len(CELLS) else ", ".join(cells)
        yield f"- {entry}: {condition.replace('|', '&#124;')} ({where})"


def cells_list() -> Iterator[str]:
    """What each cell is."""
    yield from (f"- **{cell.name}**: {cell.sentence}" for cell in CELLS)


def gains_list() -> Iterator[str]:
    """What each set of gains is, and who plays with it."""
    for gains in SETS:
        yield f"- **{gains.name}**: {gains.sentence} ({', '.join(map(label, gains.observers))})"


def _median_and_spread(errors: xr.DataArray) -> str:
    """Two lines, so that a page has room for all quantities."""
    median = float(errors.median(skipna=False))
    low, high = errors.quantile(SPREAD, "seed").values
    return f"{_whole(median)}<br>±{100 * (high - low) / 2 / median:.0f}&nbsp;%" if median else _whole(median)


def _whole(value: float) -> str:
    """A number that no line breaks at its exponent."""
    return number(value).replace("-", "−")


def _mark(played: Played, entry: str, cell: str) -> str:
    return f" {_BROKEN}" if (entry, cell) in played.violated else ""


def _head(words: Sequence[str]) -> Iterator[str]:
    yield _row(words)
    yield _row(["---"] * len(words))


def _row(words: Sequence[str]) -> str:
    return f"| {' | '.join(words)} |"
