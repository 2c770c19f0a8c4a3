"""The first samples of recordings."""

import pytest

import hillobs
from hillobs import Recording
from hillobs.studies.laboratory.subject import subject_of
from places import DATA
from shipped_recording import HINGE, SHIPPED, part


@pytest.fixture(scope="session")
def short() -> Recording:
    """1.5 s of the pair; what is known of the truth is left out."""
    return part(hillobs.read_recording(SHIPPED), slice(0, 300))


@pytest.fixture(scope="session")
def hinge_short() -> Recording:
    columns = subject_of(HINGE).columns
    return part(hillobs.read_recording(DATA / "hinge_pair_noisy.csv.gz", known=columns), slice(0, 300))
