"""The oracle `independent/` against published vectors, closed forms, a stored second solution and known tables."""

from functools import cache

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from independent.controller import lqr
from independent.measures import baselines, errors, rmse, settling
from independent.model import Model
from independent.muscle import Curves, Phi_S, Phi_S_inv, dPhi_S, g, g_inv
from independent.noise import PHILOX_VECTORS, philox4x32, sensor_noise, uniform
from independent.parameters import NOISE, SCENARIOS
from independent.run import Run, run_of
from independent.signals import pulses
from independent.simulation import simulate
from independent.states import OBSERVERS, STATES
from places import DATA

REFERENCE = DATA / "paper_clean.csv.gz"
GROUPS = {"plant": slice(0, 4), "high_gain": slice(4, 11), "sliding_mode": slice(11, 18), "adaptive": slice(18, 31)}
CLEAN = {  # x1 x2 x3 x4 Delta u1 u2 a1 a2
    "high_gain": (2.8e-6, 8.4e-5, 2.8e-5, 2.5e-5, 8.4e-4, 5.8e-4, 5.1e-4, 3.3e-3, 6.3e-4),
    "sliding_mode": (5.9e-5, 1.44e-3, 3.6e-5, 3.9e-5, 7.6e-4, 1.43e-3, 1.43e-3, 3.8e-3, 7.5e-4),
    "adaptive_sliding_mode": (3.0e-4, 7.6e-4, 9.6e-5, 9.3e-5, 6.0e-4, 7.4e-4, 7.5e-4, 7.0e-3, 1.35e-3),
}
NOISY = {
    "high_gain": (1.82e-4, 1.68e-3, 9.2e-5, 1.06e-4, 5.55e-3, 7.2e-4, 6.8e-4, 7.0e-3, 1.72e-3),
    "sliding_mode": (2.29e-4, 4.73e-3, 5.8e-5, 1.28e-4, 1.98e-2, 4.93e-3, 4.91e-3, 1.52e-2, 1.39e-3),
    "adaptive_sliding_mode": (3.18e-4, 2.50e-3, 1.04e-4, 1.65e-4, 5.72e-3, 2.56e-3, 2.57e-3, 1.07e-2, 1.70e-3),
}
CHALLENGE = {  # x2 Delta u1 a1 a2
    "high_gain": (1.85e-3, 9.9e-3, 2.47e-2, 8.7e-2, 8.3e-2),
    "sliding_mode": (1.38e-2, 2.53e-2, 1.41e-2, 2.8e-2, 3.7e-2),
    "adaptive_sliding_mode": (6.4e-3, 1.03e-2, 7.8e-3, 6.5e-2, 6.7e-2),
}


@cache
def reference() -> np.ndarray:
    return np.loadtxt(REFERENCE, delimiter=",", skiprows=1)


def differences(run: Run, every: int = 1) -> dict[str, float]:
    X = run.states[:, ::every, 0].T
    error = abs(X - reference()[: len(X), 1:32]).max(0)
    return {name: error[columns].max() for name, columns in GROUPS.items()}


# ---------------------------------------------------------------- curves, gains, noise


@pytest.mark.parametrize("constants", [{}, {"k": 17.0}, {"k": 30.0}, {"toe": 0.06, "F_toe": 0.7}])
def test_tendon_curve(constants):
    c = Curves(**constants)
    toe = c.L_slack + c.toe
    edge = np.nextafter(toe, 0)
    assert Phi_S(c.L_slack, c) == dPhi_S(c.L_slack, c) == 0
    assert Phi_S(edge, c) == pytest.approx(c.F_toe, abs=1e-12)
    assert dPhi_S(edge, c) == pytest.approx(c.k, abs=1e-10)
    L = np.linspace(c.L_slack, toe + 0.06, 20_001)
    np.testing.assert_allclose(Phi_S_inv(Phi_S(L, c), c), L, rtol=0, atol=1e-15)
    y = np.concatenate([np.geomspace(1e-300, 0.1, 2001), np.linspace(0.1, 1, 2001)])
    np.testing.assert_allclose(Phi_S(Phi_S_inv(y, c), c), y, rtol=0, atol=1e-14)
    slope = (Phi_S(L + 1e-7, c) - Phi_S(L - 1e-7, c)) / 2e-7
    np.testing.assert_allclose(dPhi_S(L, c), slope, atol=1e-4)
    assert Phi_S_inv(-0.3, c) == Phi_S_inv(0.0, c) == c.L_slack


def test_force_velocity_and_its_inverse():
    u = np.linspace(-5, 0.99, 1001)
    np.testing.assert_allclose(g_inv(g(u)), u, atol=1e-12)
    assert g(-0.9) == pytest.approx(1.45)
    assert g(0.0) == 1.0


def test_lqr_is_the_riccati_solution():
    for m, q, R in ((1.0, 10.0, 30.0), (2.3, 4.0, 0.7)):
        B = np.array([[0.0], [1 / m]])
        P = solve_continuous_are(np.array([[0.0, 1.0], [0.0, 0.0]]), B, q * np.eye(2), [[R]])
        K, closed = lqr(m, q, R)
        np.testing.assert_allclose(closed, P, rtol=1e-9)
        np.testing.assert_allclose(K, (B.T @ P / R)[0], rtol=1e-9)
    np.testing.assert_allclose(lqr(1, 10, 30)[0], (0.57735027, 1.21984994), atol=5e-9)


@pytest.mark.parametrize(("counter", "key", "words"), PHILOX_VECTORS)
def test_philox_known_answers(counter, key, words):
    assert tuple(int(w) for w in philox4x32(counter, key)) == words


def test_noise_depends_on_seed_channel_and_sample_alone():
    U = uniform(np.arange(8)[:, None, None], np.arange(3)[:, None], np.arange(4001))
    assert U[5, 2, 1234] == uniform(5, 2, 1234)
    assert U.min() > -1
    assert U.max() <= 1
    assert abs(U.mean()) < 5 / np.sqrt(3 * U.size)
    assert U.var() == pytest.approx(1 / 3, rel=0.01)
    assert np.unique(U).size == U.size
    assert uniform(1 << 32, 0, 0) != uniform(0, 0, 0)
    noise = sensor_noise(NOISE, range(3), 4001)
    assert noise[:, 0].min() >= -1e-3
    assert noise[:, 1:].min() >= 0
    assert noise.max() <= 2e-3


# ---------------------------------------------------------------- the stored solution


def test_dop853_meets_the_stored_solution():
    run = simulate({"duration": 1.2}, method="dop853")
    bounds = {"plant": 1e-12, "high_gain": 1e-11, "sliding_mode": 5e-9, "adaptive": 2e-6}
    for name, error in differences(run).items():
        assert error < bounds[name], name
    for i, known in enumerate((run.u[0], run.u[1], run.Delta[:, None], run.a[0], run.a[1])):
        np.testing.assert_allclose(known[:, 0], reference()[: run.t.size, 32 + i], atol=5e-12)


def test_rk4_meets_the_stored_solution():
    bounds = {"plant": 1e-11, "high_gain": 5e-11, "sliding_mode": 2e-7, "adaptive": 1e-4}
    for name, error in differences(simulate({"duration": 1.0}), every=20).items():
        assert error < bounds[name], name


def test_rk4_has_order_four():
    coarse, fine = (differences(simulate({"duration": 0.5, "step": h}), round(0.01 / h)) for h in (5e-3, 2.5e-3))
    assert coarse["high_gain"] / fine["high_gain"] == pytest.approx(16, rel=0.15)


def test_measures_of_the_stored_solution():
    table = reference()
    model = Model({"step": 0.01})
    run = run_of(model, table[:, 0], table[:, 1:32].T[:, :, None], np.zeros((3, 1, 1)), np.zeros(len(table)))
    for name, expected in CLEAN.items():
        np.testing.assert_allclose(rmse(errors(run, name), run.t)[:, 0], expected, rtol=0.03)
    settled = {name: settling(errors(run, name), run.t)[:7, 0] for name in OBSERVERS}
    np.testing.assert_allclose(settled["high_gain"], (0.23, 0.70, 0.71, 0.64, 0.93, 1.34, 0.54), atol=0.011)
    np.testing.assert_allclose(settled["sliding_mode"], (0.02, 0.42, 0.03, 0.04, 0.66, 0.51, 0.45), atol=0.021)
    np.testing.assert_allclose(settled["adaptive_sliding_mode"], (0.82, 0.80, 0.43, 0.40, 1.73, 0.84, 0.85), atol=0.011)


# ---------------------------------------------------------------- the tables
# long: test_loop.py holds the compiled loop against the same tables, and, step by step, against this program


@pytest.mark.chaos
def test_errors_of_paper_noisy():
    run = simulate({**NOISE, "step": 2.5e-3}, seeds=range(6))
    for name, expected in NOISY.items():
        np.testing.assert_allclose(np.median(rmse(errors(run, name), run.t), 1), expected, rtol=0.08)
    trivial = baselines(run)
    assert trivial["Delta"][0] == pytest.approx(3.5e-3, rel=0.01)
    assert trivial["x2"][0] == pytest.approx(3.6e-3, rel=0.02)
    assert 0.43 < run.a[0].min() < run.a[0].max() < 0.885
    assert abs(run.u).max() == pytest.approx(0.0275, rel=0.01)
    assert not run.slack.any()


@pytest.mark.chaos
def test_errors_of_challenge():
    run = simulate({**SCENARIOS["challenge"], "step": 2.5e-3}, seeds=range(6))
    for name, expected in CHALLENGE.items():
        error = np.median(rmse(errors(run, name), run.t), 1)
        np.testing.assert_allclose(error[[1, 4, 5, 7, 8]], expected, rtol=0.05)
    assert abs(run.u).max() == pytest.approx(0.101, rel=0.01)
    np.testing.assert_allclose(baselines(run)["a"].mean(1), (0.108, 0.109), rtol=0.01)


# ---------------------------------------------------------------- the other scenarios and the guards


def test_given_activation_is_found_again_from_the_states():
    start = {"initial.x1": 2.7727, "initial.x3": 2.0228, "initial.x4": 2.0225}
    run = simulate({"plant.drive": "given", **start, "duration": 2.0, "step": 2.5e-3})
    np.testing.assert_allclose(run.a, run.a_in, atol=1e-14)
    assert not run.flags.any()
    assert abs(run.u[:, 0]).max() < 5e-4


def test_requested_activation_is_the_virtual_drive_while_no_limit_is_active():
    virtual, requested = (
        simulate({"plant.drive": d, "duration": 0.5, "step": 2.5e-3}) for d in ("virtual", "requested")
    )
    np.testing.assert_allclose(requested.states, virtual.states, atol=1e-9)
    assert not requested.flags.any()


def test_both_slack_stays_finite_and_is_masked():
    start = {"initial.x3": 1.99, "initial.x4": 1.99}
    run = simulate({**NOISE, **start, "duration": 0.2, "step": 2.5e-3})
    assert np.isfinite(run.states).all()
    assert run.slack.all()
    for name in OBSERVERS:
        rms = rmse(errors(run, name), run.t, 0.0)
        assert np.isnan(rms[[2, 3, 5, 6, 7, 8]]).all()
        assert np.isfinite(rms[[0, 1, 4]]).all()


def test_adaptive_guards_hold_under_ten_times_the_noise():
    loud = {key: 10 * size for key, size in NOISE.items()}
    run = simulate({**loud, "adaptive_sliding_mode.r_max": 2.0, "duration": 3.0, "step": 2.5e-3}, seeds=range(4))
    assert np.isfinite(run.states).all()
    assert run.state("adaptive_sliding_mode.r_a0").max() == pytest.approx(2.0, abs=0.3)  # one step beyond r_max
    assert (run.state("adaptive_sliding_mode.l_a") + 0.4).min() > 0


def test_pulses_are_whole_steps():
    p = {"pulse.amplitude": (-0.065, 0.065), "pulse.start": (5.0, 7.0), "pulse.stop": (6.0, 8.0)}
    q = pulses(p, 1e-3, np.arange(10_001))
    assert (q[[4999, 5000, 5999, 6000, 7000, 8000]] == (0, -0.065, -0.065, 0, 0.065, 0)).all()


def test_untied_values_reach_their_consumer_only():
    base = {"duration": 0.1, "step": 2.5e-3}
    tied = simulate(base).states
    same = simulate({**base, "high_gain.m": 1.0, "high_gain.muscle1.k": 19.2308}).states
    mass = simulate({**base, "high_gain.m": 1.1}).states
    stiff = simulate({**base, "sliding_mode.muscle1.k": 17.0}).states
    np.testing.assert_array_equal(tied, same)
    assert sorted({int(i) // 7 for i in np.flatnonzero(abs(mass - tied).max((1, 2))) - 4}) == [0]
    assert {STATES[i] for i in np.flatnonzero(abs(stiff - tied).max((1, 2)))} == {
        "sliding_mode.x3_hat", "sliding_mode.u1_hat",
    }  # fmt: skip
    heavy = Model({"plant.m": 1.3})
    assert {*heavy.m.values(), heavy.controller.m} == {1.3}
