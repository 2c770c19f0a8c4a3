"""How late estimates of the Kalman filter may be: in whole samples, no longer than the recording, and told."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hillobs.studies.cli.reports.estimates.estimate import notes
from hillobs.studies.estimate.run import estimate
from hillobs.studies.files.errors import RecordingError
from hillobs.studies.laboratory.recording import Recording
from shipped_recording import MUSCLES, part

pytestmark = pytest.mark.numerics


@pytest.mark.parametrize(
    ("lag", "sentence"),
    [
        (0.012, "each estimate is 10 ms late, and knows the samples until then"),
        (0.0024, "a lag of 2.4 ms is less than half a sample, so estimates know no later one"),
        (1.2, "each estimate is 1.2 s late, and knows the samples until then"),
        (0.0, ""),
    ],
)
def test_the_lag_that_counts_is_told(lag: float, sentence: str, short: Recording) -> None:
    told = [note.strip() for note in notes(estimate(short, MUSCLES, "kalman", form="u", lag=lag)) if " late" in note]
    assert told == [sentence] * bool(sentence)


def test_a_lag_longer_than_the_recording_is_refused(short: Recording) -> None:
    with pytest.raises(RecordingError, match=r"a lag of 1.5 s is longer than the recording, 1.495 s; smooth"):
        estimate(short, MUSCLES, "kalman", form="u", lag=1.5)
    # as long as it is: all that is later is known
    few = part(short, slice(0, 60))
    late, smooth = (estimate(few, MUSCLES, "kalman", form="u", **asked) for asked in ({"lag": 0.295}, {"smooth": True}))
    np.testing.assert_allclose(late.velocity_hat, smooth.velocity_hat, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("typed", "sentence"),
    [
        ("20mm", "--lag must be a time in ms or s, such as 20ms or 0.02s, not '20mm'"),
        ("ms", "--lag must be a time in ms or s, such as 20ms or 0.02s, not 'ms'"),
        ("-20ms", "--lag must be 0 or more, not '-20ms'"),
        ("1e999s", "--lag must be a finite number, not inf"),
    ],
)
def test_what_is_no_lag_is_one_sentence(
    typed: str, sentence: str, command: Callable[..., tuple[int, str, str]]
) -> None:
    code, _, err = command("estimate", "x.csv", "--muscles", str(MUSCLES), "--observer", "kalman", "--lag", typed)
    assert (code, err) == (2, f"hillobs: {sentence}\n")
    assert not Path("estimates").exists()
