"""Trials that several tests calibrate by."""

import pytest

from held_trials import FIVE, MAXIMAL, PASSIVE, THREE, held, staircase, stretch
from hillobs.studies.laboratory.recording import Recording


@pytest.fixture(scope="session")
def five() -> Recording:
    """Five seconds of muscle 1 at its most, at five lengths."""
    return held("five.csv", staircase(FIVE), MAXIMAL)


@pytest.fixture(scope="session")
def three() -> Recording:
    return held("three.csv", staircase(THREE), MAXIMAL)


@pytest.fixture(scope="session")
def passive() -> Recording:
    """Ten seconds of both muscles at rest, stretched and let go."""
    return held("passive.csv", stretch(), PASSIVE)
