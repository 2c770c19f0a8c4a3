"""A sweep that is started, stopped, damaged, changed and resumed in any order ends as if nothing had been."""

import os
import shutil
import warnings
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule, run_state_machine_as_test

from hillobs.studies.files.errors import ResultError
from unfinished_sweeps import PARTS, EndedError, Sweep, flip


class Machine(RuleBasedStateMachine):
    """What can befall a sweep, and what holds after each step."""

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
            except EndedError:
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
        whole = path.read_bytes()
        if how == "flip":
            flip(path, data.draw(st.integers(0, 8 * path.stat().st_size - 1)))
        elif how == "cut":
            os.truncate(path, data.draw(st.integers(0, path.stat().st_size - 1)))
        else:
            shutil.copy(self.here.parts / f"{data.draw(st.sampled_from(others)):08d}.part", path)
        # a copy of the part itself, laid at another's place before, does no harm
        if path.read_bytes() != whole:
            self.damaged.add(part)

    @precondition(lambda self: self.here.parts.exists())
    @rule(name=st.sampled_from([f"{begin}-{16 * '7'}" for begin in (".00000001.part", ".x.nc", ".plan.json")]))
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


@pytest.fixture
def machine(tmp_path: Path, untouched: bytes) -> type[Machine]:
    Machine.root, Machine.untouched = tmp_path, untouched
    return Machine


@pytest.mark.hypothesis  # of a machine's test Hypothesis does not say so itself
def test_any_history_ends_in_the_same_result(machine: type[Machine]) -> None:
    run_state_machine_as_test(machine, settings=settings(max_examples=30, stateful_step_count=6, deadline=None))
