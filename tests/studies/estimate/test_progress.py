"""While one waits: progress rises to 1, observers may be compiled before, and times are told in plain numbers."""

import pytest
import xarray as xr

from hillobs.codegen.recordings import filters
from hillobs.studies.cli.reports.estimates.estimate import timing
from hillobs.studies.estimate.run import compile_observers, estimate
from hillobs.studies.laboratory.recording import Recording
from hillobs.studies.laboratory.subject import subject_of
from shipped_recording import MUSCLES, SHIPPED

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
