"""The parts of an unfinished sweep: damage is found, said once and computed again; others' parts are never mixed in."""

import errno
import fcntl
import json
import os
import random
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule, run_state_machine_as_test

from hillobs.observers.score import MEASURES
from hillobs.studies.files.errors import ResultError
from hillobs.studies.files.netcdf import sealed
from hillobs.studies.sweep import computing
from hillobs.studies.sweep import plan as planning
from hillobs.studies.sweep.parts import Parts
from hillobs.studies.sweep.row import row_of
from hillobs.studies.sweep.run import SweepWarning, sweep

EPS = {"high_gain.eps_h": [0.05, 0.1, 0.2, 0.4, 0.8]}
TINY = {"duration": 0.05, "score.start": 0.01}
PARTS = 5


class _EndedError(Exception):
    pass


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
                raise _EndedError

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
        with pytest.raises(_EndedError):
            self.run(parts)
        return self.whole()

    def whole(self) -> list[Path]:
        """The parts that are there."""
        return sorted(self.parts.glob("*.part"))


@pytest.fixture(scope="module")
def untouched(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    here = Sweep(tmp_path_factory.mktemp("untouched"))
    here.run()
    assert sorted(here.computed) == list(range(PARTS))
    return here.out.read_bytes()


@pytest.fixture
def unfinished(tmp_path: Path) -> Sweep:
    """Parts 0, 1, 2 of five are kept."""
    here = Sweep(tmp_path)
    assert [path.name for path in here.start(3)] == ["00000000.part", "00000001.part", "00000002.part"]
    return here


def assert_computed_again(here: Sweep, damaged: list[int], untouched: bytes) -> None:
    with pytest.warns(SweepWarning) as said:
        here.run()
    words = "1 damaged part is" if len(damaged) == 1 else f"{len(damaged)} damaged parts are"
    assert [str(one.message) for one in said] == [f"{here.parts}: {words} computed again"]
    assert sorted(here.computed) == sorted({*damaged, 3, 4})
    assert here.out.read_bytes() == untouched
    assert os.listdir(here.folder) == ["x.nc"]


def test_whole_parts_are_not_computed_again(unfinished: Sweep, untouched: bytes) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        unfinished.run()
    assert sorted(unfinished.computed) == [3, 4]
    assert unfinished.out.read_bytes() == untouched
    unfinished.run()
    assert unfinished.computed == []
    assert os.listdir(unfinished.folder) == ["x.nc"]


def flip(path: Path, bit: int) -> None:
    raw = bytearray(path.read_bytes())
    raw[bit // 8 % len(raw)] ^= 1 << bit % 8
    path.write_bytes(raw)


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


# of the sweeps here
ROW = row_of(["high_gain"], ["x2"], MEASURES)


def identity(part: bytes) -> str:
    return part.split()[2].decode()


def description(here: Sweep) -> dict[str, object]:
    return json.loads((here.parts / "plan.json").read_bytes()[:-40])


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


@pytest.mark.parametrize(
    "name",
    ["0.part", "1.part", "+1.part", "²²²²²²²².part", "٠٠٠٠٠٠٠١.part", "000000001.part", "99999999.part", "x.part"],
)
def test_files_with_odd_names_are_no_parts(unfinished: Sweep, untouched: bytes, name: str) -> None:
    shutil.copy(unfinished.whole()[1], unfinished.parts / name)
    unfinished.run()
    assert sorted(unfinished.computed) == [3, 4]
    assert unfinished.out.read_bytes() == untouched
    assert os.listdir(unfinished.folder) == ["x.nc"]


def test_what_a_killed_process_left_is_removed(unfinished: Sweep, untouched: bytes) -> None:
    """Half a file of a part, half a result, and the parts of a result that is there."""
    for name in (".00000003.part-abcd", ".x.nc-abcd"):
        (unfinished.parts / name).write_bytes(b"half")
    with pytest.raises(_EndedError):
        unfinished.run(1)
    assert not list(unfinished.parts.glob(".*"))
    shutil.copytree(unfinished.parts, unfinished.folder / "kept")
    unfinished.run()
    (unfinished.folder / "kept").rename(unfinished.parts)
    unfinished.run()
    assert os.listdir(unfinished.folder) == ["x.nc"]
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


@pytest.mark.parametrize("name", ["plan.json", "00000001.part"])
def test_a_file_of_a_terabyte_is_not_read(unfinished: Sweep, name: str) -> None:
    os.truncate(unfinished.parts / name, 10**12)
    with pytest.raises(ResultError, match=rf"{name} cannot be read: it is larger than 1,000,000,000 bytes"):
        unfinished.run()


@pytest.mark.parametrize("name", ["plan.json", "00000001.part", "lock"])
@pytest.mark.parametrize("what", ["folder", "pipe", "dangling link"])
def test_something_else_under_the_name_of_a_file(unfinished: Sweep, untouched: bytes, name: str, what: str) -> None:
    path = unfinished.parts / name
    path.unlink()
    if what == "folder":
        path.mkdir()
    elif what == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to(path.parent / "nowhere" / "at all")
    if what == "dangling link" and name != "lock":  # there is no such file
        unfinished.run()
        assert unfinished.out.read_bytes() == untouched
        assert os.listdir(unfinished.folder) == ["x.nc"]
    else:
        with pytest.raises(ResultError, match=r"x\.nc\.parts\S* cannot be (read|written to): "):
            unfinished.run()
        assert not unfinished.out.exists()


@pytest.mark.parametrize("what", ["file", "link", "dangling link"])
def test_something_else_under_the_name_of_the_parts(tmp_path: Path, untouched: bytes, what: str) -> None:
    here = Sweep(tmp_path)
    if what == "file":
        here.parts.write_text("mine")
    else:
        here.parts.symlink_to("elsewhere")
        if what == "link":
            (tmp_path / "elsewhere").mkdir()
    if what == "link":
        here.run()
        assert here.out.read_bytes() == untouched
    else:
        with pytest.raises(ResultError, match=r"x\.nc\.parts cannot be written to: "):
            here.run()
        assert not here.out.exists()


def test_the_parts_of_another_sweep_are_not_mixed(unfinished: Sweep) -> None:
    before = {path: path.read_bytes() for path in unfinished.whole()}
    for other, words in (
        (Sweep(unfinished.folder, {"high_gain.eps_h": [0.05, 0.1]}), "axes"),
        (Sweep(unfinished.folder, **{"plant.m": 1.1}), "scenario"),
    ):
        with pytest.raises(ResultError, match=f"unfinished sweep with other {words}; finish that one"):
            other.run()
    assert {path: path.read_bytes() for path in unfinished.whole()} == before


def test_a_lock_that_cannot_be_taken_is_no_other_process(unfinished: Sweep, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_locks(*_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", no_locks)
    with pytest.raises(ResultError, match=r"x\.nc\.parts cannot be written to: No locks available"):
        unfinished.run()


class Machine(RuleBasedStateMachine):
    """A sweep that is started, stopped, damaged, changed and resumed in any order ends as if nothing had been."""

    untouched: bytes
    root: Path
    count = 0

    @initialize()
    def begin(self) -> None:
        type(self).count += 1
        folder = self.root / str(self.count)
        folder.mkdir()
        self.here, self.damaged = Sweep(folder), set[int]()

    def parts(self) -> set[int]:
        return {int(path.stem) for path in self.here.whole()}

    def proceed(self, parts: int) -> None:
        """Run until so many more are kept; only what was missing or damaged is computed."""
        before, done = self.parts(), self.here.out.exists()
        missing = set() if done else set(range(PARTS)) - (before - self.damaged)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            try:
                self.here.run(parts)
                assert self.here.out.read_bytes() == self.untouched
            except _EndedError:
                assert len(missing) > parts
                assert self.parts() - self.damaged >= before - self.damaged
        assert len(said) == (bool(self.damaged) and not done)
        # one more may be under way when it ends
        assert set(self.here.computed) <= missing
        assert len(self.here.computed) == len(set(self.here.computed)) <= parts + 2
        if self.here.out.exists():
            assert os.listdir(self.here.folder) == ["x.nc"]
            assert set(self.here.computed) == missing
            self.damaged.clear()
        # what was damaged is so until it is computed again
        self.damaged -= set(self.here.computed)

    @rule(parts=st.integers(1, PARTS))
    def run(self, parts: int) -> None:
        self.proceed(parts)

    @precondition(lambda self: self.parts() - self.damaged)
    @rule(data=st.data(), how=st.sampled_from(["flip", "cut", "swap", "remove"]))
    def damage(self, data: st.DataObject, how: str) -> None:
        part = data.draw(st.sampled_from(sorted(self.parts() - self.damaged)))
        path = self.here.parts / f"{part:08d}.part"
        others = sorted(self.parts() - {part})
        if how == "remove" or (how == "swap" and not others):
            path.unlink()
            return
        self.damaged.add(part)
        if how == "flip":
            flip(path, data.draw(st.integers(0, 8 * path.stat().st_size - 1)))
        elif how == "cut":
            os.truncate(path, data.draw(st.integers(0, path.stat().st_size - 1)))
        else:
            shutil.copy(self.here.parts / f"{data.draw(st.sampled_from(others)):08d}.part", path)
            if is_part(path, part):
                self.damaged.discard(part)

    @precondition(lambda self: self.here.parts.exists())
    @rule(name=st.sampled_from([".00000001.part-torn", ".x.nc-torn", "notes.txt"]))
    def leave(self, name: str) -> None:
        (self.here.parts / name).write_bytes(b"half")

    @rule(m=st.floats(1.01, 2))
    def change(self, m: float) -> None:
        """Another sweep is refused and changes nothing."""
        other = Sweep(self.here.folder, **{"plant.m": m})
        files = {path: path.read_bytes() for path in self.here.folder.rglob("*.part")}
        if not self.here.out.exists() and not self.here.parts.exists():
            return
        with pytest.raises(ResultError):
            other.run()
        assert other.computed == []
        assert {path: path.read_bytes() for path in self.here.folder.rglob("*.part")} == files

    def teardown(self) -> None:
        if hasattr(self, "here"):
            self.proceed(PARTS)
            shutil.rmtree(self.here.folder)


def is_part(path: Path, part: int) -> bool:
    return path.read_bytes().partition(b"\n")[0].endswith(f"part {part}".encode())


@pytest.fixture
def machine(tmp_path: Path, untouched: bytes) -> type[Machine]:
    Machine.root, Machine.untouched = tmp_path, untouched
    return Machine


def test_any_history_ends_in_the_same_result(machine: type[Machine]) -> None:
    run_state_machine_as_test(machine, settings=settings(max_examples=30, stateful_step_count=6, deadline=None))


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
