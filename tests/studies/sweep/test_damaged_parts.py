"""Damaged parts of an unfinished sweep are found, said once and computed again."""

import json
import os
import random
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from hillobs.studies.files.datasets.netcdf import sealed
from hillobs.studies.files.errors import ResultError
from hillobs.studies.sweep import plan as planning
from hillobs.studies.sweep.parts import Parts
from hillobs.studies.sweep.run import SweepWarning
from unfinished_sweeps import PARTS, ROW, Sweep, assert_computed_again, flip


def identity(part: bytes) -> str:
    return part.split()[2].decode()


def description(here: Sweep) -> dict[str, object]:
    return json.loads((here.parts / "plan.json").read_bytes()[:-40])


# a part has about 1,700 bytes
@pytest.mark.parametrize("first", range(0, 64, 16))
def test_flipped_bits_are_found(unfinished: Sweep, untouched: bytes, first: int) -> None:
    """64 bits, sixteen after another in one part, then a second in another."""
    path = unfinished.whole()[1]
    good = path.read_bytes()
    draw = random.Random(first)
    for bit in [0, 8 * len(good) - 1, *draw.sample(range(8 * len(good)), 13)]:
        flip(path, bit)
        with Parts(unfinished.out, identity(good), description(unfinished), ROW) as parts:
            assert parts.read(1) is None
            assert parts.damaged == 1
        path.write_bytes(good)
    flip(path, 8 * 1000 + 3)
    flip(unfinished.whole()[2], 8 * 200)
    assert_computed_again(unfinished, [1, 2], untouched)


DAMAGES: dict[str, Callable[[Path], object]] = {
    **{f"cut to {size}": lambda path, size=size: os.truncate(path, size) for size in (0, 1, 39, 40, 41, 100, 1000)},
    "cut by 1": lambda path: os.truncate(path, path.stat().st_size - 1),
    "zeros": lambda path: path.write_bytes(bytes(path.stat().st_size)),
    "a byte more": lambda path: path.write_bytes(path.read_bytes() + b"\0"),
    "twice": lambda path: path.write_bytes(path.read_bytes() * 2),
    "text": lambda path: path.write_text("nothing of ours"),
    "sealed, but nothing": lambda path: path.write_bytes(sealed(b"")),
    "sealed, but text": lambda path: path.write_bytes(sealed("größer\n".encode())),
    "another part": lambda path: shutil.copy(path.with_name("00000002.part"), path),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_part_is_computed_again(unfinished: Sweep, untouched: bytes, damage: Callable) -> None:
    damage(unfinished.whole()[1])
    assert_computed_again(unfinished, [1], untouched)


def test_parts_that_changed_their_names(unfinished: Sweep, untouched: bytes) -> None:
    first, second, third = unfinished.whole()
    first.rename(first.with_name("swap"))
    third.rename(first)
    (unfinished.parts / "swap").rename(third)
    second.rename(second.with_name("00000004.part"))
    with pytest.warns(SweepWarning, match="3 damaged parts"):
        unfinished.run()
    assert sorted(unfinished.computed) == list(range(PARTS))
    assert unfinished.out.read_bytes() == untouched


@pytest.mark.parametrize(
    "other",
    [
        {"plant.m": 1.1},
        {"noise.x1": 2e-3},
        {"duration": 0.1},
    ],
    ids=str,
)
def test_a_part_of_another_sweep(tmp_path: Path, untouched: bytes, other: dict[str, float]) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "here").mkdir()
    stranger, here = Sweep(tmp_path / "other", **other), Sweep(tmp_path / "here")
    here.start(3)
    shutil.copy(stranger.start(3)[1], here.whole()[1])
    assert_computed_again(here, [1], untouched)


def test_a_part_of_other_code(unfinished: Sweep, untouched: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    """The name of the library is part of what a part says of itself."""
    whole = planning.Plan.description
    with monkeypatch.context() as patch:
        patch.setattr(planning.Plan, "description", lambda plan, library: whole(plan, library + "x"))
        with pytest.raises(ResultError, match="unfinished sweep with other code"):
            unfinished.run()
        (unfinished.parts / "plan.json").unlink()
        with pytest.warns(SweepWarning, match="3 damaged parts"):
            assert unfinished.start(4)
    (unfinished.parts / "plan.json").unlink()
    with pytest.warns(SweepWarning, match="4 damaged parts"):
        unfinished.run()
    assert unfinished.out.read_bytes() == untouched


PLANS: dict[str, Callable[[Path], object]] = {
    "gone": Path.unlink,
    "empty": lambda path: path.write_bytes(b""),
    "cut": lambda path: os.truncate(path, 100),
    "flipped": lambda path: flip(path, 800),
    "100,000 brackets": lambda path: path.write_bytes(b"[" * 100_000),
    "100,000 sealed zeros less one byte": lambda path: path.write_bytes(sealed(bytes(100_000))[:-1]),
    "another seal": lambda path: path.write_bytes(path.read_bytes()[:-32] + bytes(32)),
}


@pytest.mark.parametrize("damage", PLANS.values(), ids=PLANS)
def test_a_damaged_plan_loses_no_part(unfinished: Sweep, untouched: bytes, damage: Callable) -> None:
    """Each part says itself whose it is."""
    damage(unfinished.parts / "plan.json")
    unfinished.run()
    assert sorted(unfinished.computed) == [3, 4]
    assert unfinished.out.read_bytes() == untouched
