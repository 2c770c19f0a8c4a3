"""What the first pass measures: noise that is known, time scales by the closed form, sizes of a motion."""

import math

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from hillobs.studies.estimate.sizes.noise import despiked, even_steps, noise
from hillobs.studies.estimate.sizes.timescales import filled, smoothed, twice_integrated
from known_motion import MOTION, SIGMA, looked_at, recorded, rms, sines


def test_white_noise_is_measured_whatever_lies_under_it() -> None:
    y, _ = recorded(duration=200)
    for signal, sigma in zip(y, SIGMA, strict=False):
        found = noise(signal, 0.05)
        assert found.sigma == pytest.approx(sigma, rel=0.2)
        assert found.correlation == 1


def test_noise_of_uneven_steps_is_that_of_the_even_ones() -> None:
    random = np.random.default_rng(5)
    t = np.arange(8000) * 0.05
    signal = 3 + 0.2 * np.sin(1.3 * t) + 1e-3 * random.normal(size=len(t))
    kept = random.random(len(t)) > 0.25
    even = even_steps(t[kept], 0.05)
    # 0.75⁵ of the differences are over even steps: some 1400
    assert noise(signal[kept], 0.05, even).sigma == pytest.approx(1e-3, rel=0.1)
    assert noise(signal[kept], 0.05).sigma > 1.3e-3
    # where hardly any step is even all of them count, as where all are
    assert noise(signal, 0.05, np.zeros(len(t) - 1, dtype=bool)) == noise(signal, 0.05)
    assert noise(signal, 0.05, even_steps(t, 0.05)) == noise(signal, 0.05)


def test_where_samples_are_missing_there_are_straight_lines_and_time_is_as_it_was() -> None:
    t = np.array([0.0, 0.1, 0.2, 0.5, 0.61, 0.7, 0.9])
    grid = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.61, 0.7, 0.8, 0.9])
    np.testing.assert_allclose(filled(np.array([t, 2 * t]), t, 0.1), [grid, 2 * grid])
    even = np.arange(9.0)[None]
    assert filled(even, np.arange(9) * 0.1, 0.1) is even
    # nearly all would be made up
    rare = np.array([0.0, 0.1, 0.2, 9.0])
    assert filled(even[:, :4], rare, 0.1).shape == (1, 4)


def test_noise_of_a_hardware_filter_is_noise_and_its_length_is_found() -> None:
    # a Butterworth filter of a tenth of the sampling rate
    together = lfilter(*butter(2, 0.2), np.random.default_rng(2).normal(size=20_000))
    together /= together.std()
    t = np.arange(20_000) * 0.01
    found = noise(3 + 0.2 * np.sin(t) + 1e-3 * together, 0.01)
    assert found.sigma == pytest.approx(1e-3, rel=0.2)
    assert 2 <= found.correlation <= 8
    # from sample to sample it shows a fraction of itself
    assert noise(1e-3 * together, 1.0).sigma < 0.5e-3


def test_a_signal_without_noise_has_none() -> None:
    assert noise(np.sin(np.arange(0, 20, 0.01)), 0.01).sigma < 1e-9


def test_rounding_is_noise() -> None:
    t = np.arange(0, 50, 0.01)
    step = 1e-3
    found = noise(np.round(0.1 * np.sin(0.3 * t) / step) * step, 0.01)
    assert step / math.sqrt(12) * 0.999 <= found.sigma <= step


def test_single_wild_samples_go_and_many_stay() -> None:
    t = np.arange(0, 20, 0.01)
    signal = np.sin(t)
    wild = signal.copy()
    wild[[100, 700, 1500]] += 1
    np.testing.assert_allclose(despiked(wild, 1e-3), signal, atol=0.01)
    wild[::20] += 1
    np.testing.assert_array_equal(despiked(wild, 1e-3), wild)


def test_a_linear_acceleration_is_integrated_exactly() -> None:
    T = 0.3
    t = np.arange(0, 6, T)
    np.testing.assert_allclose(twice_integrated(2 - 3 * t, T), t**2 - t**3 / 2, atol=1e-11)


def test_smoothing_keeps_lines_and_has_no_lag() -> None:
    t = np.arange(0, 40 * math.pi + 1e-9, math.pi / 200)
    np.testing.assert_allclose(smoothed(3 - 2 * t, 0.1, 1.0), 3 - 2 * t, atol=1e-9)
    # sin is odd at both ends, so the filter only scales it: 1/(1 + (ωτ)²)² twice over
    np.testing.assert_allclose(smoothed(np.sin(t), math.pi / 200, 0.5), np.sin(t) / 1.25**2, atol=1e-3)
    assert rms(smoothed(np.random.default_rng(3).normal(size=5000), 0.01, 0.5)[300:-300]) < 0.1


def test_the_closed_form_agrees() -> None:
    T = 0.05
    t = np.arange(0, 100, T)
    sizes = looked_at(recorded(T)[0], T)
    rates = {name: rms(sines(terms, t, 1)) for name, terms in MOTION.items()}
    accelerations = {name: rms(sines(terms, t, 2)) for name, terms in MOTION.items()}
    u, du = (math.sqrt(found["u1"] * found["u2"]) for found in (rates, accelerations))
    assert sizes.eps_1 == pytest.approx(0.72 * (SIGMA[0] ** 2 * T / rates["Delta"] ** 2) ** (1 / 7), rel=0.2)
    assert sizes.eps_L == pytest.approx(0.585 * (SIGMA[1] ** 2 * T / u**2) ** (1 / 5), rel=0.2)
    assert sizes.eps_L3 == pytest.approx(0.72 * (SIGMA[1] ** 2 * T / du**2) ** (1 / 7), rel=0.2)


def test_the_sizes_are_those_of_the_motion() -> None:
    y, truth = recorded()
    sizes = looked_at(y, 0.05)
    assert sizes.D == pytest.approx(rms(truth["Delta"]), rel=0.1)
    assert sizes.D_max == pytest.approx(np.abs(truth["Delta"]).max(), rel=0.25)
    assert sizes.U == pytest.approx(rms(np.array([truth["u1"], truth["u2"]])), rel=0.1)
    assert sizes.U_max == pytest.approx(max(np.abs(truth["u1"]).max(), np.abs(truth["u2"]).max()), rel=0.25)
