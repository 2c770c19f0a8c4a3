"""While one waits: progress rises to 1, observers may be compiled before, and times are told in plain numbers."""

import itertools
from pathlib import Path

import pytest
import xarray as xr

from hillobs.codegen.recordings import filters
from hillobs.studies.cli.reports.estimates.estimate import notes, timing
from hillobs.studies.estimate.files import save_estimates
from hillobs.studies.estimate.run import compile_observers, estimate
from hillobs.studies.laboratory.recording import Recording
from hillobs.studies.laboratory.subject import subject_of
from shipped_recording import MUSCLES, SHIPPED, part

pytestmark = pytest.mark.numerics


def test_progress_rises_to_1_over_reading_and_all_observers(short: Recording) -> None:
    told: list[float] = []
    estimate(short, MUSCLES, progress=told.append)
    assert told == sorted(told)
    assert (told[0] > 0, told[-1], len(told)) == (True, 1, 3)
    told.clear()
    estimate(SHIPPED, MUSCLES, progress=told.append)
    assert told == sorted(told)
    # the file is the first of four parts
    assert (told[0] <= 0.25, 0.25 in told, told[-1]) == (True, True, 1)


def test_the_kalman_filter_tells_each_of_its_phases(short: Recording) -> None:
    told: list[float] = []
    estimate(short, MUSCLES, "kalman", form="a", smooth=True, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1
    # five orders of the first pass, four fits of the second, two passes
    assert len({round(done, 6) for done in told}) >= 5 + 4 + 2
    assert max(after - before for before, after in itertools.pairwise([0.0, *told])) < 0.3


def test_writing_tells_each_file(noisy: xr.Dataset, tmp_path: Path) -> None:
    told: list[float] = []
    few = noisy.isel(time=slice(0, 50)).sel(observer=["high_gain", "kalman"])
    paths = save_estimates(few, [], tmp_path, told.append)
    assert told == [(i + 1) / len(paths) for i in range(len(paths))]


@pytest.mark.parametrize("samples", [49, 50])
def test_a_recording_too_short_for_statistics_says_so(samples: int, short: Recording) -> None:
    told = " ".join(notes(estimate(part(short, slice(0, samples)), MUSCLES, "high_gain")))
    assert ("fewer than 50 samples tell neither noise nor speed" in told) == (samples < 50)


@pytest.mark.parametrize(
    ("seconds", "sentence"),
    [
        ((0.052, 9.04, 0.0312), "read in 0.05 s, observers built in 9.04 s, followed in 0.03 s: 16 µs a sample"),
        ((12.3, 36.2, 1712.0), "read in 12 s, observers built in 36 s, followed in 1,712 s: 855,572 µs a sample"),
        ((0.0, 0.0, 0.0), "read in 0.00 s, observers built in 0.00 s, followed in 0.00 s: 0.0 µs a sample"),
    ],
)
def test_times_are_told_without_powers_of_ten(
    seconds: tuple[float, float, float], sentence: str, noisy: xr.Dataset
) -> None:
    assert timing(noisy, *seconds) == sentence


def test_observers_are_built_before_they_are_needed(short: Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    compile_observers(subject_of(MUSCLES), "high_gain")
    monkeypatch.setattr(filters, "load", lambda *arguments: pytest.fail("compiled"))
    estimate(short, MUSCLES, "high_gain")
