"""Every fault of a sweep, at every call, in forks of one process. Minutes long."""

import itertools
import signal
from pathlib import Path

import pytest

from places import contents
from survival import ERRORS, STOPPED, SWEEP, assert_a_signal_ends_both, assert_goes_on, assert_survives

pytestmark = pytest.mark.chaos


@pytest.mark.parametrize(
    ("fault", "ever"),
    [("SIGKILL", False), *itertools.product(ERRORS, [False, True])],  # nobody is killed twice
    ids=lambda of: {False: "once", True: "ever"}.get(of, of),
)
def test_each_call(forks, untouched, tmp_path, record_property, fault: str, ever: bool) -> None:
    whole, calls = untouched
    for at in range(1, len(calls) + 1):
        done = assert_survives(forks, tmp_path / str(at), whole, fault=fault, at=at, ever=ever)
        assert done.code in ({-signal.SIGKILL} if fault == "SIGKILL" else {0, 2})
        assert done.code != 2 or ERRORS[fault] in done.err
    record_property("faults", len(calls))


@pytest.mark.parametrize("twice", [False, True], ids=["once", "twice"])
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_at_each_call(forks, untouched, tmp_path, record_property, name: str, twice: bool) -> None:
    whole, calls = untouched
    for at in range(1, len(calls) + 1):
        done = assert_survives(forks, tmp_path / str(at), whole, fault=name, at=at, twice=twice)
        assert done.code == 128 + getattr(signal, name)
        assert done.err in STOPPED
    record_property("faults", len(calls))


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_at_each_call_of_the_drawing(forks, untouched, tmp_path, record_property, name: str) -> None:
    drawing = [word for word in SWEEP if word != "--no-figures"]
    (tmp_path / "first").mkdir()
    calls = forks.run(tmp_path / "first", *drawing).calls
    first = next(i for i, call in enumerate(calls, 1) if "x-curves" in call)
    for at in range(first, len(calls) + 1):
        folder = tmp_path / str(at)
        folder.mkdir()
        done = forks.run(folder, *drawing, fault=name, at=at)
        assert done.code == 128 + getattr(signal, name)
        assert (folder / "x.nc").read_bytes() == untouched[0]
        assert forks.run(folder, *drawing).computed == []
        assert sorted(contents(folder)) == ["x-curves.png", "x.nc"]
    record_property("faults", len(calls) - first + 1)


@pytest.mark.parametrize("name", ["INT", "HUP"])
def test_a_signal_while_the_compiler_runs_ends_both(tmp_path: Path, name: str) -> None:
    assert_a_signal_ends_both(tmp_path, name)


@pytest.mark.parametrize("size", range(0, 16_000, 250))
def test_files_that_may_not_grow(forks, untouched, tmp_path, size: int) -> None:
    done = assert_survives(forks, tmp_path / "here", untouched[0], limits={"RLIMIT_FSIZE": size})
    assert done.code in (0, 2)
    assert done.code == 0 or "File too large" in done.err


@pytest.mark.parametrize("megabytes", range(0, 400, 25))
def test_little_memory(forks, untouched, tmp_path, megabytes: int) -> None:
    """Whatever is refused memory, it is a sentence; with enough the result is right."""
    (tmp_path / "here").mkdir()
    limits = {"RLIMIT_AS": forks.memory() + megabytes * 1_000_000}
    done = forks.run(tmp_path / "here", *SWEEP, limits=limits)
    assert done.code in (0, 2)
    assert "Traceback" not in done.err
    assert_goes_on(forks, tmp_path / "here", untouched[0])


@pytest.mark.parametrize("descriptors", range(16, 24))
def test_few_descriptors(forks, untouched, tmp_path, descriptors: int) -> None:
    done = assert_survives(forks, tmp_path / "here", untouched[0], limits={"RLIMIT_NOFILE": descriptors})
    assert done.code in (0, 2)
