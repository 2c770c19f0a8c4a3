"""Recordings of pairs that are drawn: the Kalman filter's bands hold, and its smoother is better than its filter."""

import functools

import numpy as np
import pytest
import xarray as xr

from hillobs.observers.ports import ESTIMATES
from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.scores import SETTLED
from hillobs.studies.kalman.muscles import ACTIVATION, compiled_muscles
from hillobs.studies.laboratory.scales import scales
from random_recordings import KINDS, Drawn, drawn

pytestmark = pytest.mark.numerics

FEW, SECONDS, SLOWLY = range(6), 4.0, (100.0,)
# two sides of a normal distribution have 95 % within
BAND = 1.96


@functools.cache
def few() -> list[Drawn]:
    return [drawn(seed, SECONDS, SLOWLY, (KINDS[seed % len(KINDS)],)) for seed in FEW]


def followed(one: Drawn, smooth: bool, form: str = "auto") -> xr.Dataset:
    estimates = estimate(one.recording, one.pair, "kalman", form=form, smooth=smooth)
    return estimates.sel(observer="kalman", time=slice(SETTLED, None))


def rmse(of: xr.Dataset, name: str) -> float:
    return float(np.sqrt(((of[f"{name}_hat"] - of[f"true_{name}"]) ** 2).mean()))


def covered(of: xr.Dataset, name: str) -> float:
    return float((abs(of[f"{name}_hat"] - of[f"true_{name}"]) < BAND * of[f"{name}_sd"]).mean())


def test_what_is_drawn_moves_as_the_equations_say() -> None:
    for one in few():
        true, pair, s = one.recording.true, one.pair, scales(one.pair)
        known = dict.fromkeys(ESTIMATES, 0 * true["position"]) | {"x1_hat": s.lengths(true["position"])}
        for j in (1, 2):
            known[f"x{j + 2}_hat"] = s.lengths(true[f"tendon_length_{j}"])
            known[f"u{j}_hat"] = -true[f"fibre_velocity_{j}"] / (s.length * s.rate)
        numbers = {path.removeprefix("plant."): value for path, value in s.numbers.items()}
        found = compiled_muscles(pair.curves).outputs(ACTIVATION, {"u_low": -5, "u_high": 0.95, **numbers}, known)
        for j in (1, 2):
            np.testing.assert_allclose(found[f"a{j}_hat"], true[f"activation_{j}"], rtol=1e-9)


def test_it_is_the_same_each_time_and_another_with_another_seed() -> None:
    again, other = drawn(0, SECONDS, SLOWLY, KINDS[:1]), drawn(3, SECONDS, SLOWLY, KINDS[:1])
    np.testing.assert_array_equal(again.recording.force_1, few()[0].recording.force_1)
    assert again.pair == few()[0].pair != other.pair
