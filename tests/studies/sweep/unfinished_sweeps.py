"""A sweep of five parts that ends early, damage to what it leaves, and what a second run makes of that."""

import os
from pathlib import Path

import pytest
import xarray as xr

from hillobs.observers.score import MEASURES
from hillobs.studies.sweep import computing
from hillobs.studies.sweep import plan as planning
from hillobs.studies.sweep.row import row_of
from hillobs.studies.sweep.run import SweepWarning, sweep

EPS = {"high_gain.eps_h": [0.05, 0.1, 0.2, 0.4, 0.8]}
TINY = {"duration": 0.05, "score.start": 0.01}
PARTS = 5

# what a part of it keeps
ROW = row_of(["high_gain"], ["x2"], MEASURES)


class EndedError(Exception):
    """A sweep is stopped after so many parts."""


class Sweep:
    """A sweep of five parts into one file, which counts what it computes."""

    def __init__(self, folder: Path, over: object = EPS, **changes: float) -> None:
        self.folder, self.over, self.changes = folder, over, {**TINY, **changes}
        self.out, self.parts = folder / "x.nc", folder / "x.nc.parts"
        self.computed: list[int] = []

    def run(self, parts: int = PARTS) -> xr.Dataset:
        """All of it, or until so many more parts are kept."""
        self.computed.clear()
        before = -1

        def progress(done: int, runs: int) -> None:
            nonlocal before
            before = done if before < 0 else before
            if done - before >= 4 * parts and done < runs:
                raise EndedError

        def counting(*given: object) -> object:
            self.computed.append(given[2])
            return compute_part(*given)

        compute_part = computing.compute_part
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(computing, "compute_part", counting)
            patch.setattr(planning, "PART", 4)
            given = {"out": self.out, "workers": 1, "progress": progress, "quantities": ["x2"]}
            return sweep("paper-noisy", self.over, 4, "high_gain", self.changes, **given)

    def start(self, parts: int) -> list[Path]:
        """Keep so many parts, and end."""
        with pytest.raises(EndedError):
            self.run(parts)
        return self.whole()

    def whole(self) -> list[Path]:
        """The parts that are there."""
        return sorted(self.parts.glob("*.part"))


def assert_computed_again(here: Sweep, damaged: list[int], untouched: bytes) -> None:
    """The damage is said once, nothing else is computed again, and the result is that of an undisturbed sweep."""
    with pytest.warns(SweepWarning) as said:
        here.run()
    words = "1 damaged part is" if len(damaged) == 1 else f"{len(damaged)} damaged parts are"
    assert [str(warning.message) for warning in said] == [f"{here.parts}: {words} computed again"]
    assert sorted(here.computed) == sorted({*damaged, 3, 4})
    assert here.out.read_bytes() == untouched
    assert os.listdir(here.folder) == ["x.nc"]


def flip(path: Path, bit: int) -> None:
    """Change one bit of a file."""
    raw = bytearray(path.read_bytes())
    raw[bit // 8 % len(raw)] ^= 1 << bit % 8
    path.write_bytes(raw)
