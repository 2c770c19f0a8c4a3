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
    found = read_recording(DATA / name)
    true = found.true
    assert len(found) == 101
    assert found.time.dtype == np.float64
    assert set(true) == set(COLUMNS) - {"time", "position", "force_1", "force_2"} - {
        f"{key}_measured" for key in ("position", "force_1", "force_2")
    }
    np.testing.assert_allclose(found.time, np.arange(101) / 10, atol=1e-12)
    np.testing.assert_allclose(true["tendon_length_1"] + true["fibre_length_1"], found.position, atol=2e-9)
    np.testing.assert_allclose(true["tendon_length_2"] + true["fibre_length_2"], C - found.position, atol=2e-9)
    # mass·acceleration = force_2 − force_1 + disturbance
    push = found.force_2 - found.force_1 + true["disturbance"]
    np.testing.assert_allclose(20 * true["acceleration"], push, atol=2e-6)
    assert found.rows[0] == (8 if name.endswith(".sto") else 2)
    assert found.notes() == []


def test_measured_columns_are_the_inputs_and_the_plain_ones_the_truth() -> None:
    found = read_recording(SHIPPED)
    assert (len(found), found.source) == (2001, SHIPPED.name)
    for name, sd in (("position", 1e-4), ("force_1", 5.0), ("force_2", 5.0)):
        noise = getattr(found, name) - found.true[name]
        assert np.std(noise) == pytest.approx(sd, rel=0.06)
    assert not [name for name in found.true if "measured" in name]
    plain = read_recording(SHIPPED, {"position": "position"})
    assert np.array_equal(plain.position, found.true["position"])
    assert "position" not in plain.true
    assert np.array_equal(plain.force_1, found.force_1)
