"""Threads that the system does not grant: a sweep goes on with those it gets, to the same bits."""

import queue
import threading
import warnings

import pytest
import xarray as xr

from hillobs.studies.sweep import computing
from hillobs.studies.sweep import plan as planning
from hillobs.studies.sweep.computing import SweepWarning
from hillobs.studies.sweep.run import sweep

SHORT = {"duration": 0.2, "score.start": 0.05}


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planning, "PART", 4)


def swept(workers: int) -> xr.Dataset:
    return sweep("paper-noisy", {"plant.m": [1, 1.1]}, 8, "high_gain", SHORT, workers=workers)


@pytest.mark.parametrize("granted", [0, 1, 2])
@pytest.mark.parametrize("limit", ["memory", "threads"])
def test_fewer_threads_compute_the_same(granted: int, limit: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, began, start = swept(1), [], threading.Thread.start

    def start_if_granted(thread: threading.Thread) -> None:
        if limit == "threads" and len(began) == granted:
            raise RuntimeError("can't start new thread")
        start(thread)
        began.append(thread)

    with monkeypatch.context() as patched:
        patched.setattr(threading.Thread, "start", start_if_granted)
        if limit == "memory":
            patched.setattr(computing, "has_room", lambda _: len(began) < granted)
        with pytest.warns(SweepWarning, match=f"^the system grants {granted} of 3 threads; the sweep takes longer$"):
            xr.testing.assert_equal(swept(3), whole)
    assert len(began) == granted
    assert not any(thread.is_alive() for thread in began)


def test_all_threads_that_are_granted_are_used_without_a_word() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        xr.testing.assert_equal(swept(3), swept(1))


def test_a_thread_that_dies_without_a_word_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where not even its failure finds memory to be told."""
    monkeypatch.setattr(computing, "_LOOK", 0.01)
    dead = threading.Thread(target=lambda: None)
    dead.start()
    dead.join()
    with pytest.raises(MemoryError):
        computing._next(queue.SimpleQueue(), [dead])
