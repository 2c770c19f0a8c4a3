"""The parts of an unfinished sweep: kept to the bit, not computed again, never mixed, and gone when it has ended."""

import os
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

from hillobs.studies.files.errors import ResultError
from hillobs.studies.sweep.parts import Parts
from unfinished_sweeps import ROW, EndedError, Sweep

# what makes a temporary name unlike others
CHANCE = "0123456789abcdef"


def test_whole_parts_are_not_computed_again(unfinished: Sweep, untouched: bytes) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        unfinished.run()
    assert sorted(unfinished.computed) == [3, 4]
    assert unfinished.out.read_bytes() == untouched
    unfinished.run()
    assert unfinished.computed == []
    assert os.listdir(unfinished.folder) == ["x.nc"]


def test_what_a_killed_process_left_is_removed(unfinished: Sweep, untouched: bytes) -> None:
    """Half a file of a part, half a result, and the parts of a result that is there."""
    for name in (f".00000003.part-{CHANCE}", f".x.nc-{CHANCE}"):
        (unfinished.parts / name).write_bytes(b"half")
    with pytest.raises(EndedError):
        unfinished.run(1)
    assert not list(unfinished.parts.glob(".*"))
    shutil.copytree(unfinished.parts, unfinished.folder / "kept")
    unfinished.run()
    (unfinished.folder / "kept").rename(unfinished.parts)
    unfinished.run()
    assert os.listdir(unfinished.folder) == ["x.nc"]
    assert unfinished.out.read_bytes() == untouched


def test_the_parts_of_another_sweep_are_not_mixed(unfinished: Sweep) -> None:
    before = {path: path.read_bytes() for path in unfinished.whole()}
    for other, words in (
        (Sweep(unfinished.folder, {"high_gain.eps_h": [0.05, 0.1]}), "axes"),
        (Sweep(unfinished.folder, **{"plant.m": 1.1}), "scenario"),
    ):
        with pytest.raises(ResultError, match=f"unfinished sweep with other {words}; finish that one"):
            other.run()
    assert {path: path.read_bytes() for path in unfinished.whole()} == before


def test_numbers_of_any_kind_are_kept_bit_by_bit(tmp_path: Path) -> None:
    bits = np.random.default_rng(1).integers(0, 2**64, 999, dtype=np.uint64)
    odd = np.array([np.nan, -np.nan, np.inf, -np.inf, -0.0, 5e-324, 1.7976931348623157e308])
    rows = np.zeros(len(bits) + len(odd), ROW)
    rows["rmse"] = np.concatenate([bits.view(np.float64), odd])[:, None, None]
    rows["failure"] = np.arange(len(rows))[:, None] - 500
    with Parts(tmp_path / "x.nc", "me", {}, ROW) as parts:
        parts.write(7, rows)
        assert list(parts) == [7]
        assert parts.read(7).dtype == ROW
        assert parts.read(7).tobytes() == rows.tobytes()
        assert parts.read(8) is None
        assert parts.damaged == 0
