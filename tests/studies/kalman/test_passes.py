"""Filter and smoother over a recording: against other texts of them, themselves in pieces, and a score's meaning."""

import functools
import itertools

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

from hillobs.model.arrays import Array
from hillobs.observers.behind.spread import COVARIANCES
from hillobs.observers.kalman.activations import ACTIVATIONS_MODEL
from hillobs.observers.kalman.exponential import driven, exponential
from hillobs.observers.kalman.inputs import INPUTS_MODEL
from hillobs.observers.kalman.model import Model
from hillobs.observers.ports import ESTIMATES
from hillobs.studies.kalman import run
from hillobs.studies.kalman.fit import fitted
from hillobs.studies.kalman.passes import Filtered, Smoothed, compiled, log_likelihood, table
from hillobs.studies.kalman.run import How, over
from independent import kalman as independent
from independent.muscle import Curves, Phi_S_inv

pytestmark = pytest.mark.numerics

NUMBERS = independent.Model(2, 2, m=0.7, sigma=(1e-3, 2e-3, 3e-3), s=(0.02, 0.05, 0.08))
MODELS = pytest.mark.parametrize("model", [INPUTS_MODEL, ACTIVATIONS_MODEL], ids=["inputs", "activations"])


def recorded(n: int) -> tuple[Array, Array]:
    """Times and measurements of nothing in particular, with some noise."""
    random = np.random.default_rng(3)
    t = np.cumsum(random.uniform(0.3, 1.7, n)) * 0.05
    y = np.stack([2.62 + 0.05 * np.sin(t), 0.5 + 0.25 * np.sin(2 * t), 0.5 + 0.2 * np.cos(3 * t)], axis=1)
    return t, y + random.normal(size=(n, 3)) * 1e-3


@functools.cache
def rows(model: Model, n: int) -> Array:
    """The same as a table, all of it seen and counted; about a law of nothing in particular."""
    t, y = recorded(n)
    z = Phi_S_inv(y[:, 1:], Curves())
    slopes = np.array([independent.tendon_slopes(here) for here in z])
    columns = {"t": t, "y1": y[:, 0], "acc": (y[:, 2] - y[:, 1]) / NUMBERS.m}
    columns |= {"L_S1": z[:, 0], "L_S2": z[:, 1], "slope1": slopes[:, 0], "slope2": slopes[:, 1]}
    columns |= {"x1_hat": y[:, 0], "x3_hat": z[:, 0], "x4_hat": z[:, 1], "a1_hat": 0.3 + 0 * t, "a2_hat": 0.4 + 0 * t}
    columns |= {"u_1": 0.1 * np.sin(t), "u_2": 0.1 * np.cos(t), "b_x1_1": -0.5 + 0 * t, "b_x1_2": 0.4 + 0 * t}
    columns |= {"b_x3_1": -20 + np.sin(t), "b_x4_2": -30 + np.cos(t), "b_a1_1": 0.8 + 0 * t, "b_a2_2": 0.7 + 0 * t}
    return table(model, columns | {"seen": np.ones(n), "counted": np.ones(n)})


def values(model: Model, **given: float) -> dict[str, float]:
    defaults = {name: parameter.default for name, parameter in model.parameters.items()}
    return {**defaults, **{n: v for n, v in independent.numbers(NUMBERS).items() if n in defaults}, **given}


def passed(model: Model, numbers: dict[str, float], rows: Array, lag: int = 0) -> tuple[Filtered, Smoothed]:
    passes = compiled(model)
    motions = passes.motions(numbers, rows)
    filtered = passes.filtered(numbers, passes.start(numbers, rows[0]), rows, motions)
    return filtered, passes.smoothed(numbers, rows, motions, filtered, lag)


@pytest.mark.parametrize("orders", [(1, 1), (2, 2), (3, 3), (1, 3)])
def test_the_smoother_is_that_of_rauch_tung_and_striebel(orders: tuple[int, int]) -> None:
    model = independent.Model(*orders, m=0.7, sigma=NUMBERS.sigma, s=NUMBERS.s)
    steps = independent.filtered(model, *recorded(150))
    x, P = independent.smoothed(steps)
    numbers = values(INPUTS_MODEL, **independent.numbers(model))
    filtered, found = passed(INPUTS_MODEL, numbers, rows(INPUTS_MODEL, 150))
    names = ["x1", "x2", "x3", "x4", "Delta", "u1", "u2"]
    places = dict(zip(names, [0, 1, 2, 3, *(chain.start for chain in model.chains)], strict=True))
    told = dict(zip(compiled(INPUTS_MODEL).told, found.told.T, strict=True))
    # theirs inverts P⁻, whose condition number is up to 1e8 here: half of its digits are left
    for name in ESTIMATES:
        np.testing.assert_allclose(told[name], x[:, places[name.removesuffix("_hat")]], atol=1e-7)
    sds = {name: np.sqrt(P[:, i, i]) for name, i in places.items()}
    for entry in COVARIANCES:
        a, b = entry.split(".")[1:]
        scale = sds[a] * sds[b]
        np.testing.assert_allclose(told[entry] / scale, P[:, places[a], places[b]] / scale, atol=1e-6)
    assert log_likelihood(filtered, rows(INPUTS_MODEL, 150)) == pytest.approx(
        sum(step.log_likelihood for step in steps), rel=1e-10
    )


@MODELS
def test_a_lag_of_all_samples_is_the_smoother_and_a_lag_of_some_knows_no_more(model: Model) -> None:
    numbers, all_rows = values(model), rows(model, 80)
    _, smoothed = passed(model, numbers, all_rows)
    _, late = passed(model, numbers, all_rows, lag=80)
    np.testing.assert_allclose(late.told, smoothed.told, rtol=1e-12, atol=1e-14)
    _, some = passed(model, numbers, all_rows, lag=7)
    for k in (0, 30, 72):
        _, until = passed(model, numbers, all_rows[: k + 8])
        np.testing.assert_allclose(some.told[k], until.told[k], rtol=1e-12, atol=1e-14)
    filtered, _ = passed(model, numbers, all_rows)
    # nothing is known later than the last sample
    np.testing.assert_allclose(smoothed.told[-1], filtered.told[-1], rtol=1e-9, atol=1e-12)


@MODELS
def test_the_score_is_the_derivative_of_the_likelihood(model: Model) -> None:
    numbers, all_rows = values(model), rows(model, 300)
    _, smoothed = passed(model, numbers, all_rows)
    for name, (found, expected) in zip(compiled(model).densities, smoothed.score, strict=True):
        q, step = numbers[name] ** 2, 1e-4

        def at(factor: float, name: str = name, q: float = q) -> float:
            return log_likelihood(passed(model, {**numbers, name: np.sqrt(q * factor)}, all_rows)[0], all_rows)

        difference = (at(1 + step) - at(1 - step)) / (2 * step)
        # rounding of log L ~ 1e4 over the step, and its third derivative times the step squared
        assert q * (found - expected) / 2 == pytest.approx(difference, rel=1e-5, abs=1e-4)


@MODELS
def test_what_is_not_seen_changes_nothing(model: Model) -> None:
    numbers, all_rows = values(model), rows(model, 80).copy()
    all_rows[40:45, -2] = 0
    wild = all_rows.copy()
    # noise of what nobody sees; forces act on the mass all the same
    wild[40:45, 1] += 0.1
    for one, other in zip(passed(model, numbers, all_rows), passed(model, numbers, wild), strict=True):
        np.testing.assert_array_equal(one.told, other.told)
    seen, unseen = passed(model, numbers, rows(model, 80))[0], passed(model, numbers, all_rows)[0]
    assert log_likelihood(unseen, all_rows) != log_likelihood(seen, rows(model, 80))
    np.testing.assert_array_equal(unseen.told[:40], seen.told[:40])


@MODELS
@pytest.mark.parametrize("lag", [0, 5, None])
def test_in_pieces_it_is_the_same(model: Model, lag: int | None, monkeypatch: pytest.MonkeyPatch) -> None:
    numbers, all_rows = values(model), rows(model, 400)
    (whole,) = over(compiled(model), numbers, all_rows, How(lag=lag), 400)
    monkeypatch.setattr(run, "_PIECE", 90)
    pieces = np.concatenate(list(over(compiled(model), numbers, all_rows, How(lag=lag), 300)))
    if lag is None:
        # the slowest chain forgets within 300 samples of 0.05: w = (0.02/(1e-3 √0.05))^¼ = 3, e^(−3·15 cos 72°) = 1e-6
        np.testing.assert_allclose(pieces, whole, rtol=1e-5, atol=1e-5)
    else:
        np.testing.assert_array_equal(pieces, whole)


def test_the_fixed_point_finds_one_maximum_from_far_away() -> None:
    passes, all_rows = compiled(INPUTS_MODEL), rows(INPUTS_MODEL, 400)
    names = ("s_D", "s_u1", "s_u2")
    found = []
    for factors in itertools.product((1e-2, 1e2), repeat=3):
        start = {name: values(INPUTS_MODEL)[name] * factor for name, factor in zip(names, factors, strict=True)}
        found.append(fitted(passes, [all_rows], values(INPUTS_MODEL, **start), dict.fromkeys(names, 1e-9)))
    likelihoods = [fit.log_likelihood for fit in found]
    assert max(likelihoods) - min(likelihoods) < 0.3
    assert max(fit.passes for fit in found) < 60


def test_a_density_is_never_below_its_least() -> None:
    passes, all_rows = compiled(INPUTS_MODEL), rows(INPUTS_MODEL, 100)
    least = {"s_D": 3.0, "s_u1": 1e-9, "s_u2": 1e-9}
    found = fitted(passes, [all_rows], values(INPUTS_MODEL, s_D=3.0), least)
    free = fitted(passes, [all_rows], values(INPUTS_MODEL, s_D=3.0), {**least, "s_D": 1e-9})
    assert free.numbers["s_D"] < found.numbers["s_D"] == 3.0
    assert free.log_likelihood > found.log_likelihood


@pytest.mark.parametrize("norm", [0.01, 1.0, 25.0])
def test_the_exponential_is_scipys(norm: float) -> None:
    random = np.random.default_rng(1)
    A = random.normal(size=(6, 6)) - 2 * np.eye(6)
    A *= norm / np.linalg.norm(A, 2)
    found = np.array(ca.DM(exponential(ca.SX(A))))
    # ten squarings double a rounding ten times
    np.testing.assert_allclose(found, expm(A), atol=2**10 * 1e-15 * max(1, np.linalg.norm(expm(A), 2)))


def test_what_drives_it_goes_in_a_straight_line() -> None:
    random = np.random.default_rng(2)
    A, before, after, T = random.normal(size=(4, 4)), random.normal(size=4), random.normal(size=4), 0.3
    F, b = (np.array(ca.DM(value)) for value in driven(ca.SX(A), ca.SX(before), ca.SX(after), ca.SX(T)))
    np.testing.assert_allclose(F, expm(A * T), atol=1e-12)
    # by the trapezoidal rule, with an error of T³/12 |f″|/n²
    s, n = np.linspace(0, T, 2001), 2000
    integrand = [expm(A * (T - at)) @ (before + (after - before) * at / T) for at in s]
    np.testing.assert_allclose(b[:, 0], np.trapezoid(integrand, s, axis=0), atol=T**3 / 12 * 1e3 / n**2)
