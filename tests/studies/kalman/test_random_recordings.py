"""Recordings of pairs that are drawn: the Kalman filter's bands hold, and its smoother is better than its filter."""

import functools
import json

import numpy as np
import pytest
import xarray as xr

from hillobs.model.system import pair_system
from hillobs.observers.ports import ESTIMATES
from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.scores import SETTLED
from hillobs.studies.kalman.muscles import ACTIVATION, compiled_muscles
from hillobs.studies.laboratory.scales import scales
from random_recordings import KINDS, Drawn, drawn

pytestmark = pytest.mark.numerics

FEW, SECONDS, SLOWLY = 6, 4.0, (100.0,)
# of these few, those with activations that a line through Hill's law follows without a rest
LAWFUL = (0, 1, 4)
MANY, FASTER = range(1000, 1064), (100.0, 200.0)
# 95 % of a normal distribution are within so many standard deviations
BAND = 1.96
# what a band may cover: errors are correlated, so that 8 s have few independent ones
FILTER, SMOOTHER, MOST = (0.92, 0.98), (0.92, 0.99), 0.8


@functools.cache
def few() -> list[Drawn]:
    return [drawn(seed, SECONDS, SLOWLY, (KINDS[seed % len(KINDS)],)) for seed in range(FEW)]


@functools.cache
def many() -> list[Drawn]:
    return [drawn(seed, rates=FASTER) for seed in MANY]


def followed(one: Drawn, smooth: bool, form: str = "auto") -> xr.Dataset:
    """By a pair that is known exactly, after a second."""
    estimates = estimate(one.recording, one.pair, "kalman", form=form, smooth=smooth, usual_doubt=False)
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
        found = compiled_muscles(pair_system(pair.curves)).outputs(
            ACTIVATION, {"u_low": -5, "u_high": 0.95, **numbers}, known
        )
        for j in (1, 2):
            np.testing.assert_allclose(found[f"a{j}_hat"], true[f"activation_{j}"], rtol=1e-9)
        # ∫v dt by the trapezoidal rule, whose error is below T² max|dv/dt|/12 per s
        T, v, path = 1 / SLOWLY[0], true["velocity"], true["position"] - true["position"][0]
        moved = np.concatenate([[0], np.cumsum((v[1:] + v[:-1]) / 2 * T)])
        assert abs(moved - path).max() < T**2 / 12 * SECONDS * abs(np.gradient(np.gradient(v, T), T)).max()


def test_it_is_the_same_each_time_and_another_with_another_seed() -> None:
    again, other = drawn(0, SECONDS, SLOWLY, KINDS[:1]), drawn(3, SECONDS, SLOWLY, KINDS[:1])
    np.testing.assert_array_equal(again.recording["force_1"], few()[0].recording["force_1"])
    assert again.pair == few()[0].pair != other.pair


def test_a_few_are_followed_with_bands_that_hold() -> None:
    filtered, smoothed = ([followed(one, smooth) for one in few()] for smooth in (False, True))
    for before, after in zip(filtered, smoothed, strict=True):
        assert rmse(after, "activation") < rmse(before, "activation")
        assert rmse(after, "velocity") < rmse(before, "velocity")
    for several, (low, high) in ((filtered, FILTER), (smoothed, SMOOTHER)):
        assert low < np.mean([covered(of, "activation") for of in several]) < high


def test_noise_of_the_forces_shifts_no_tendon_length() -> None:
    """A tendon is stiffer where the measured force is higher by chance: weighed by that, its length would be too large.

    By 1.5 σ²/(Φ_S + 0.2) of force for these curves, which is σ/√n times 4.7 of n = 4000 samples.
    """
    one, noise = drawn(1, SECONDS, (1000.0,), ("sines",)), np.random.default_rng(5)
    recording, n = one.recording, len(one.recording)
    sigma = {j: 0.02 * getattr(one.pair, f"muscle{j}").F_max for j in (1, 2)}
    forces = {f"force_{j}": recording.true[f"force_{j}"] + sigma[j] * noise.normal(size=n) for j in sigma}
    of = estimate(recording.remeasured(**forces), one.pair, "kalman", form="u", smooth=True).sel(observer="kalman")
    for j in sigma:
        # σ/√n as a length, by the slope between the extremes
        force, length = recording.true[f"force_{j}"], recording.true[f"tendon_length_{j}"]
        expected = sigma[j] / np.sqrt(n) * np.ptp(length) / np.ptp(force)
        error = float((of.tendon_length_hat - of.true_tendon_length).sel(muscle=j).mean())
        assert abs(error) < 3 * expected, (j, error / expected)


def test_no_noise_is_added_to_a_law_that_holds() -> None:
    """A density that ought to be 0 is hardly less likely at a value that makes the velocity twice as uncertain."""
    for one in (few()[seed] for seed in LAWFUL):
        gains = json.loads(followed(one, True, "a").attrs["gains"])["kalman"]
        # over a whole recording it moves a tendon by less than a tenth of the least noise drawn, 0.02 mm of 0.2 m
        drift = max(gains["kalman.s_x3"], gains["kalman.s_x4"]) * np.sqrt(scales(one.pair).rate * SECONDS)
        assert drift < 1e-5


@pytest.mark.chaos
@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
@pytest.mark.parametrize("form", ["u", "auto"])
def test_many_are_followed_with_bands_that_hold(form: str, smooth: bool, record_property) -> None:
    found = [followed(one, smooth, form) for one in many()]
    low, high = SMOOTHER if smooth else FILTER
    for name in ("activation", "velocity", "disturbance"):
        errors, shares = ([measure(of, name) for of in found] for measure in (rmse, covered))
        record_property(f"{name}: RMSE of 50, 90, 100 %", np.percentile(errors, [50, 90, 100]).tolist())
        record_property(f"{name}: covered in 10, 50, 90 %", np.percentile(shares, [10, 50, 90]).tolist())
        record_property(f"{name}: worst seed", MANY[int(np.argmax(errors))])
        assert np.isfinite(errors).all()
        if name == "activation":
            assert np.mean([low < share < high for share in shares]) > MOST
