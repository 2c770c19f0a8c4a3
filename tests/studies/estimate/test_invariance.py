"""What does not matter: units and sizes, left and right, the clock's zero, the other observers, pieces."""

import dataclasses

import numpy as np
import pytest
import xarray as xr
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hillobs.studies.cli.reports.estimates.estimate import notes
from hillobs.studies.estimate import follow
from hillobs.studies.estimate.run import estimate
from hillobs.studies.laboratory.muscles import MusclePair, read_muscles
from hillobs.studies.laboratory.recording import Recording
from shipped_recording import ALL_OBSERVERS, MUSCLES, SHIPPED, part

pytestmark = pytest.mark.numerics


# masses stay below the largest that a pair may have, 10⁶ kg
@settings(max_examples=10)
@given(
    st.floats(1e-2, 1e3), st.floats(0.1, 5), st.floats(0.5, 5), st.sampled_from(["high_gain", "adaptive_sliding_mode"])
)
@example(7.3, 0.31, 1.7, "sliding_mode")
def test_units_and_sizes_change_no_activation(
    short: Recording, force: float, length: float, rate: float, observer: str
) -> None:
    pair = read_muscles(MUSCLES)
    muscle = dataclasses.replace(
        pair.muscle1,
        F_max=pair.muscle1.F_max * force,
        optimal_fibre_length=pair.muscle1.optimal_fibre_length * length,
        tendon_slack_length=pair.muscle1.tendon_slack_length * length,
        v_max=pair.muscle1.v_max * rate,
    )
    # m = mass l₀ v_max²/F_max
    mass = pair.mass * force / (length * rate**2)
    other = MusclePair(mass, pair.C * length, muscle, muscle)
    scaled = dataclasses.replace(
        short,
        time=short.time / rate,
        measured={
            "position": short["position"] * length,
            "force_1": short["force_1"] * force,
            "force_2": short["force_2"] * force,
        },
    )
    before, after = estimate(short, pair, observer), estimate(scaled, other, observer)
    np.testing.assert_allclose(after.activation_hat, before.activation_hat, atol=1e-9)
    np.testing.assert_allclose(after.velocity_hat, before.velocity_hat * length * rate, atol=1e-9 * length * rate)
    np.testing.assert_allclose(after.disturbance_hat, before.disturbance_hat * force, atol=1e-6 * force)
    # usual doubts are parts of the numbers
    np.testing.assert_allclose(after.activation_sd_muscle, before.activation_sd_muscle, rtol=1e-6)
    np.testing.assert_allclose(after.fibre_length_sd_muscle, before.fibre_length_sd_muscle * length, rtol=1e-6)


def test_the_mirror_image_has_its_muscles_swapped(short: Recording) -> None:
    pair = read_muscles(MUSCLES)
    mirrored = short.remeasured(position=pair.C - short["position"], force_1=short["force_2"], force_2=short["force_1"])
    before, after = estimate(short, pair, ALL_OBSERVERS), estimate(mirrored, pair, ALL_OBSERVERS)
    # the adaptive laws jump; what is left of a rounding error is larger there
    np.testing.assert_allclose(after.activation_hat[..., ::-1], before.activation_hat, atol=1e-6)
    np.testing.assert_allclose(after.velocity_hat, -before.velocity_hat, atol=1e-7)
    np.testing.assert_allclose(after.activation_sd_muscle[..., ::-1], before.activation_sd_muscle, atol=1e-6)


def test_when_it_began_does_not_matter(short: Recording) -> None:
    later = dataclasses.replace(short, time=short.time + 1024.0)
    before, after = (estimate(one, MUSCLES, "high_gain") for one in (short, later))
    np.testing.assert_allclose(after.activation_hat, before.activation_hat, atol=1e-8)
    assert after.time[0] == 1024


def test_observers_do_not_see_each_other_nor_how_much_is_kept(noisy: xr.Dataset) -> None:
    alone = estimate(SHIPPED, MUSCLES, "sliding_mode", keep_every=7)
    for name in alone.data_vars:
        whole = noisy[name].sel(observer=["sliding_mode"]) if "observer" in noisy[name].dims else noisy[name]
        xr.testing.assert_identical(alone[name], whole.isel(time=slice(None, None, 7), missing_dims="ignore"))
    assert alone.sizes["time"] == 286
    assert "estimates are kept of every 7th sample" in list(notes(alone))


@pytest.mark.parametrize("chunk", [1, 37, 299, 300])
def test_pieces_change_no_bit(short: Recording, chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    uneven = part(short, np.flatnonzero(np.arange(300) % 7 < 5))
    told: list[float] = []
    whole = estimate(uneven, MUSCLES, "sliding_mode", keep_every=3)
    monkeypatch.setattr(follow, "_CHUNK", chunk)
    xr.testing.assert_identical(estimate(uneven, MUSCLES, "sliding_mode", keep_every=3, progress=told.append), whole)
    assert told == sorted(told)
    assert told[-1] == 1
