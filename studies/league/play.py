"""All entries in all cells: an entry is an observer with a set of gains."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from ...observers import label
from ..files.progress import CountedProgress
from ..scenarios.prepare import BASELINE
from ..sweep.run import sweep
from .cells import CELLS, Cell
from .gains import SETS, Gains


class Entry(NamedTuple):
    """An observer with a set of gains."""

    observer: str
    gains: str

    def __str__(self) -> str:
        return label(self.observer) if self.gains == SETS[0].name else f"{label(self.observer)} {self.gains}"


class Played(NamedTuple):
    """errors: RMSE (entry, cell, seed, quantity), NaN of a run that failed, with the baseline as the last entry.

    violated: (entry, cell) → the gain conditions that do not hold.
    """

    errors: xr.DataArray
    violated: dict[tuple[str, str], list[str]]


def entries() -> list[Entry]:
    """Observer by observer, and each with its sets."""
    observers = dict.fromkeys(observer for gains in SETS for observer in gains.observers)
    return [Entry(name, gains.name) for name in observers for gains in SETS if name in gains.observers]


def played(seeds: Sequence[int], progress: CountedProgress) -> Played:
    """Every entry in every cell, with the noise of these seeds."""
    errors: dict[tuple[str, str], xr.DataArray] = {}
    violated: dict[tuple[str, str], list[str]] = {}
    games = [(cell, gains) for cell in CELLS for gains in SETS]
    for done, (cell, gains) in enumerate(games):
        progress(done, len(games))
        found = _game(cell, gains, seeds)
        broken = json.loads(found.attrs["violated_conditions"])
        for name in found.observer.values.tolist():
            key = (BASELINE if name == BASELINE else str(Entry(name, gains.name)), cell.name)
            errors.setdefault(key, found.rmse.sel(observer=name, drop=True))
            if name in broken:
                violated[key] = broken[name]
    names = [*map(str, entries()), BASELINE]
    table = np.array([[errors[name, cell.name].values for cell in CELLS] for name in names])
    one = next(iter(errors.values()))
    coordinates = {"entry": names, "cell": [cell.name for cell in CELLS], **{d: one[d].values for d in one.dims}}
    return Played(xr.DataArray(table, coordinates, ("entry", "cell", *one.dims)), violated)


def _game(cell: Cell, gains: Gains, seeds: Sequence[int]) -> xr.Dataset:
    """One set of gains in one cell."""
    observers = [*gains.observers, BASELINE]
    changes = {**cell.changes_for(gains.observers), **gains.numbers(cell)}
    return sweep(cell.source, {}, seeds, observers, changes, corrected=gains.corrected)
