"""Three sweeps that many rooms look at; nobody changes them."""

import pytest
import xarray as xr

from hillobs.studies.sweep.axes import Range
from hillobs.studies.sweep.run import sweep
from short_sweeps import EPS, SHORT


@pytest.fixture(scope="session")
def line() -> xr.Dataset:
    """Over ε_h, which is the high-gain observer's alone."""
    return sweep("paper-noisy", {"high_gain.eps_h": EPS}, 3, ["high_gain", "sliding_mode"], SHORT)


@pytest.fixture(scope="session")
def plane() -> xr.Dataset:
    """Over ε_h and the noise of the position."""
    over = {"high_gain.eps_h": EPS, "noise.x1": Range(0, 0.004, 5)}
    return sweep("paper-noisy", over, 3, changes=SHORT)


@pytest.fixture(scope="session")
def layer() -> xr.Dataset:
    """Over δ_s = δ_L, from where its integration condition fails: h α/δ_L < 2.5 is δ_L > 2.2e-4."""
    over = {"sliding_mode.delta_s": [1e-4, 2e-4, 1e-3, 1e-2, 1e-1]}
    return sweep("paper-noisy", over, 3, ["sliding_mode", "high_gain"], SHORT)
