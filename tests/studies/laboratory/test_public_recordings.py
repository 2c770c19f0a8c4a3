"""The public recordings are read right: names, signs and units are OpenSim's; measured columns are the inputs."""

import numpy as np
import pytest

from hillobs.studies.laboratory.columns import COLUMNS
from hillobs.studies.laboratory.recording import read_recording
from places import DATA, RECORDINGS

SHIPPED = RECORDINGS / "dgf_smooth_noisy.csv.gz"
EXCERPTS = ("dgf_smooth_excerpt.csv", "dgf_random_excerpt.sto", "millard_steps_excerpt.csv.gz")
# distance between the origins in all of them
C = 0.62


@pytest.mark.parametrize("name", EXCERPTS)
def test_public_recordings_read_right(name: str) -> None:
    recording = read_recording(DATA / name)
    true = recording.true
    assert len(recording) == 101
    assert recording.time.dtype == np.float64
    assert set(true) == set(COLUMNS.known) - {"time", "position", "force_1", "force_2"} - {
        f"{key}_measured" for key in ("position", "force_1", "force_2")
    }
    np.testing.assert_allclose(recording.time, np.arange(101) / 10, atol=1e-12)
    np.testing.assert_allclose(true["tendon_length_1"] + true["fibre_length_1"], recording["position"], atol=2e-9)
    np.testing.assert_allclose(true["tendon_length_2"] + true["fibre_length_2"], C - recording["position"], atol=2e-9)
    # mass·acceleration = force_2 − force_1 + disturbance
    push = recording["force_2"] - recording["force_1"] + true["disturbance"]
    np.testing.assert_allclose(20 * true["acceleration"], push, atol=2e-6)
    assert recording.rows[0] == (8 if name.endswith(".sto") else 2)
    assert recording.notes() == []


def test_measured_columns_are_the_inputs_and_the_plain_ones_the_truth() -> None:
    recording = read_recording(SHIPPED)
    assert (len(recording), recording.source) == (2001, SHIPPED.name)
    for name, sd in (("position", 1e-4), ("force_1", 5.0), ("force_2", 5.0)):
        noise = recording[name] - recording.true[name]
        assert np.std(noise) == pytest.approx(sd, rel=0.06)
    assert not [name for name in recording.true if "measured" in name]
    plain = read_recording(SHIPPED, {"position": "position"})
    assert np.array_equal(plain["position"], recording.true["position"])
    assert "position" not in plain.true
    assert np.array_equal(plain["force_1"], recording["force_1"])
