"""Samples of a recording one by one, and what estimates of them are beside those of the whole."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from hillobs import Estimate, Follower, Recording

QUANTITIES = ["position", "velocity", "disturbance", "tendon_length", "fibre_length", "fibre_velocity", "activation"]


def rows(recording: Recording) -> list[list[float]]:
    """Time, then what was measured, sample by sample."""
    return np.stack([recording.time, *recording.measured.values()], axis=1).tolist()


def stepped(follower: Follower, samples: Sequence[Sequence[float]]) -> list[Estimate]:
    return [follower.step(*values, time=time) for time, *values in samples]


def numbers(estimates: Sequence[Estimate], quantity: str) -> np.ndarray:
    """(samples) or (samples × joints or muscles)."""
    values = [getattr(estimate, quantity) for estimate in estimates]
    return np.array([list(value.values()) if isinstance(value, dict) else value for value in values])


def assert_same(estimates: Sequence[Estimate], dataset: xr.Dataset, observer: str) -> None:
    """To the last bit; NaN is NaN."""
    for quantity in QUANTITIES:
        known = dataset[f"{quantity}_hat"].sel(observer=observer).values
        assert numbers(estimates, quantity).tobytes() == known.tobytes(), (observer, quantity)
