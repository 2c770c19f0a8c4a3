"""The Kalman filter: against dense matrices, other filters, the limit of its gains, and what it says of its errors."""

import dataclasses
import functools
from collections.abc import Mapping

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from hillobs.codegen.bank import Bank
from hillobs.codegen.recordings.filters import CompiledBank
from hillobs.model.block import Block, Symbols
from hillobs.model.wiring import rename, wire
from hillobs.observers import estimator
from hillobs.observers.behind.spread import COVARIANCES, SPREADS, entry, spread
from hillobs.observers.kalman.constant import KALMAN_CONSTANT, butterworth
from hillobs.observers.kalman.filter import kalman
from hillobs.observers.kalman.motion import Motion
from hillobs.observers.kalman.states import ENTRIES, INDEX, MEAN, QUANTITIES
from hillobs.observers.slopes import tendon_slopes
from hillobs.observers.tendons import tendons
from independent import kalman as independent
from independent.kalman import Model
from independent.muscle import Curves, activation

pytestmark = pytest.mark.numerics

ORDERS = [(oD, ou) for oD in (1, 2, 3) for ou in (1, 2, 3)]


@functools.cache
def compiled() -> CompiledBank:
    """The filter alone, with all that it knows as outputs: means, then covariances."""
    front = wire(
        "front",
        [tendons(), tendon_slopes()],
        {"tendons.y2": "y2", "tendons.y3": "y3", "slopes.L_S1": "tendons.L_S1", "slopes.L_S2": "tendons.L_S2"},
        {"y2": "staged", "y3": "staged"},
    )
    front = rename(front, "front", {key: key.partition(".")[2] for key in (*front.y, *front.p)})
    block = kalman()
    # the front takes its numbers from the observer
    own = {**block.parameters, **front.parameters}
    p = Symbols({name: block.p.get(name, ca.SX.sym(name)) for name in own})
    whole = dataclasses.replace(block, y=block.x.only([*MEAN, *ENTRIES]), p=p, parameters=own)
    return CompiledBank(Bank(("y1", "y2", "y3"), front, None, (whole,)))


def followed(t: np.ndarray, y: np.ndarray, given: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Means (samples × 13) and covariances (samples × 13 × 13)."""
    bank = compiled()
    (block,) = bank.bank.observers
    values = [given.get(name, parameter.default) for name, parameter in block.parameters.items()]
    found = bank.follow("kalman", values, 1).samples(t, y).y
    return found[:, : len(MEAN)], matrices(found[:, len(MEAN) :])


def matrices(entries: np.ndarray) -> np.ndarray:
    """Covariances (samples × 13 × 13) of their entries."""
    P = np.zeros((len(entries), len(INDEX), len(INDEX)))
    for place, name in enumerate(ENTRIES):
        i, j = (INDEX[part] for part in name.split(".")[1:])
        P[:, i, j] = P[:, j, i] = entries[:, place]
    return P


def in_use(model: Model) -> list[int]:
    """Where the states of the orders of `model` are among all."""
    chains = [list(QUANTITIES[4 + 3 * k : 7 + 3 * k])[: c.stop - c.start] for k, c in enumerate(model.chains)]
    return [0, 1, 2, 3, *(INDEX[name] for chain in chains for name in chain)]


def recorded(n: int, forces: float = 0.2, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Times and measurements of nothing in particular, with some noise; tendons of 0.2 go slack now and then."""
    random = np.random.default_rng(seed)
    t = np.cumsum(random.uniform(0.3, 1.7, n)) * 0.05
    y = np.stack([2.62 + 0.05 * np.sin(t), forces + 0.25 * np.sin(2 * t), forces + 0.2 * np.cos(3 * t)], axis=1)
    return t, y + random.normal(size=(n, 3)) * 1e-3


@pytest.mark.parametrize("orders", ORDERS)
def test_the_filter_is_that_of_an_independent_text_for_all_orders(orders: tuple[int, int]) -> None:
    t, y = recorded(200)
    assert (y <= 0).any()
    model = Model(*orders, m=0.7, sigma=(1e-3, 2e-3, 3e-3), s=(0.02, 0.05, 0.08))
    x, P = followed(t, y, independent.numbers(model))
    theirs, their_P = independent.kalman(model, t, y)
    used = in_use(model)
    # 200 steps of numbers below 10, of a stable filter: roundings do not grow
    np.testing.assert_allclose(x[:, used], theirs, atol=1e-11)
    scale = np.sqrt(np.einsum("ki,kj->kij", *[np.diagonal(their_P, axis1=1, axis2=2)] * 2))
    np.testing.assert_allclose(P[:, used][:, :, used] / scale, their_P / scale, atol=1e-11)
    # a derivative beyond the order is known to be 0
    unused = [i for i in INDEX.values() if i not in used]
    assert not x[:, unused].any()
    assert not P[:, unused].any()


@pytest.mark.parametrize("other", [independent.extended, independent.unscented])
def test_on_straight_tendons_it_is_the_extended_and_the_unscented_filter_of_the_plant(other) -> None:
    """Then what is measured drops out of its acceleration, and (Φ_S(x₄) − Φ_S(x₃))/m is left."""
    t, y = recorded(100, forces=4)
    model = Model(2, 2, m=0.7, sigma=(1e-3, 2e-3, 3e-3), s=(0.02, 0.05, 0.08))
    x, P = followed(t, y, independent.numbers(model))
    theirs, their_P = other(model, t, y)
    used = in_use(model)
    # RK4 of 40 steps in ΩT < 0.7 leaves (ΩT/40)⁴/120 = 8e−10 of rates up to 1
    np.testing.assert_allclose(x[:, used], theirs, atol=5e-9)
    sd, their_sd = (np.sqrt(np.diagonal(every, axis1=1, axis2=2)) for every in (P[:, used][:, :, used], their_P))
    np.testing.assert_allclose(sd, their_sd, rtol=1e-7)


def motion(p1: float, p2: float, m: float, T: float) -> np.ndarray:
    C, B = Motion(*(ca.SX(value) for value in (p1, p2, m, T))).factors()
    return np.array(ca.DM(C @ B))


def exact(p1: float, p2: float, m: float, T: float) -> np.ndarray:
    model = Model(3, 3, m=m)
    A = model.drift()
    A[1, 2], A[1, 3] = -p1 / m, p2 / m
    return expm(A * T)


@settings(max_examples=60)
@given(p=st.tuples(*[st.floats(0.5, 60)] * 2), m=st.floats(1e-3, 1e3), T=st.floats(1e-4, 0.7))
def test_the_motion_in_closed_form_is_the_exponential(p: tuple[float, float], m: float, T: float) -> None:
    # beyond ΩT = 10 the tendons count as softer
    softer = min(1.0, 10**2 * m / (sum(p) * T**2))
    expected = exact(softer * p[0], softer * p[1], m, T)
    # the recursion multiplies roundings of φ₄ by (ΩT)⁴ ≤ 10⁴
    np.testing.assert_allclose(motion(*p, m, T), expected, rtol=1e-11, atol=1e-12 * np.abs(expected).max())


def test_no_time_is_no_motion() -> None:
    np.testing.assert_array_equal(motion(13.0, 9.0, 0.7, 0.0), np.eye(len(INDEX)))


def assert_positive(P: np.ndarray) -> None:
    """Symmetric by construction; no variance and no eigenvalue of the correlations below 0 but for roundings."""
    sd = np.sqrt(np.diagonal(P, axis1=1, axis2=2))
    assert (sd > 0).all()
    correlations = P / sd[:, :, None] / sd[:, None, :]
    # an eigenvalue of a matrix of ones, of 10 states: 10 · 2⁻⁵² per operation, of some 10 in a row
    assert np.linalg.eigvalsh(correlations).min() > -1e-13


@pytest.mark.parametrize("sigma", [1e-9, 1e-3])
def test_the_covariance_stays_positive(sigma: float) -> None:
    t, y = recorded(5000)
    model = Model(sigma=(sigma,) * 3)
    used = in_use(model)
    assert_positive(followed(t, y, independent.numbers(model))[1][:, used][:, :, used])


@pytest.mark.chaos
def test_the_covariance_stays_positive_over_a_million_samples() -> None:
    bank = compiled()
    (block,) = bank.bank.observers
    values = [parameter.default for parameter in block.parameters.values()]
    filter_ = bank.follow("kalman", values, 1)
    for piece in range(100):
        t, y = recorded(10_000, seed=piece)
        found = filter_.samples(t + piece * 1000, y).y
        P = matrices(found[:, len(MEAN) :])
        used = in_use(Model())
        assert_positive(P[:, used][:, :, used])


# constant gains


@pytest.mark.parametrize("n", [2, 3, 4, 5])
def test_the_constant_gains_are_the_limit_of_the_riccati_recursion(n: int) -> None:
    sigma, T = 1e-3, 0.01
    errors = []
    for wT in (0.04, 0.02):
        # s = σ√T wⁿ
        s = sigma * np.sqrt(T) * (wT / T) ** n
        K = independent.steady_gains(n, s, sigma, T) / T / (wT / T) ** np.arange(1, n + 1)
        errors.append(np.abs(K - butterworth(n)).max())
    # a sampled filter has the gains of the continuous one up to O(wT)
    assert errors[1] < 0.02 * n * max(butterworth(n))
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.1)


@pytest.mark.parametrize("n", range(1, 6))
def test_a_butterworth_polynomial_has_all_its_roots_on_the_left_half_of_the_unit_circle(n: int) -> None:
    roots = np.roots([1, *butterworth(n)])
    # of the double roots that numpy does not have here: simple ones, good to a few roundings
    np.testing.assert_allclose(np.abs(roots), 1, rtol=1e-12)
    assert (roots.real < 0).all()
    # D(s)D(−s) = 1 + (−s²)ⁿ, the spectral factorisation of the steady filter
    np.testing.assert_allclose(roots ** (2 * n), -((-1) ** n), rtol=1e-11)


@pytest.mark.parametrize("orders", ORDERS)
def test_the_injections_are_those_of_the_chains_in_use(orders: tuple[int, int]) -> None:
    block = KALMAN_CONSTANT.block()
    given = {"order_D": orders[0], "order_u": orders[1], "s_D": 0.3, "s_u1": 0.2, "s_u2": 0.1}
    numbers = {**{name: parameter.default for name, parameter in block.parameters.items()}, **given}
    injections = ca.jacobian(block.dx.vector(), ca.vertcat(block.u.y1, block.u.L_S1, block.u.L_S2))
    found = np.array(ca.DM(ca.substitute(injections, block.p.vector(), ca.DM([numbers[name] for name in block.p]))))
    rows = {"y1": ("x1", "x2", "Delta", "dDelta", "ddDelta"), "L_S1": ("x3", "u1", "du1", "ddu1")}
    rows["L_S2"] = ("x4", "u2", "du2", "ddu2")
    sigmas, chains = ("sigma_1", "sigma_L", "sigma_L"), zip((0, 1, 1), ("s_D", "s_u1", "s_u2"), strict=True)
    for k, (names, sigma, (which, s)) in enumerate(zip(rows.values(), sigmas, chains, strict=True)):
        n = orders[which] + (2 if which == 0 else 1)
        w = (numbers[s] / (numbers[sigma] * np.sqrt(numbers["T"]))) ** (1 / n)
        expected = np.zeros(len(block.x))
        places = [list(block.x).index(f"{name}_hat") for name in names[:n]]
        expected[places] = w ** np.arange(1, n + 1) * butterworth(n)
        np.testing.assert_allclose(found[:, k], expected, rtol=1e-12)


# what it says of its errors


def test_a_standard_deviation_is_that_of_the_covariance_carried_through_the_activation() -> None:
    block = spread()
    random = np.random.default_rng(5)
    root = random.normal(size=(7, 7)) * 1e-3
    names = ("x1", "x2", "x3", "x4", "Delta", "u1", "u2")
    P, x = root @ root.T, dict(zip(names, (2.62, 0.01, 2.02, 2.021, 0.01, 0.05, -0.04), strict=True))
    values = {f"{name}_hat": value for name, value in x.items()}
    values |= {entry(a, b): P[i, j] for i, a in enumerate(names) for j, b in enumerate(names) if entry(a, b) in block.u}
    function = ca.Function("spread", [block.u.vector(), block.p.vector()], [block.y.vector()])
    defaults = [parameter.default for parameter in block.parameters.values()]
    found = dict(zip(block.y, np.array(function([values[name] for name in block.u], defaults)).ravel(), strict=True))
    assert list(found) == list(SPREADS)

    def estimated(x: np.ndarray) -> np.ndarray:
        """x, a₁, a₂, L_C1, L_C2."""
        x1, _, x3, x4, _, u1, u2 = x
        a = activation(np.array([x1]), np.array([[x3], [x4]]), np.array([[u1], [u2]]), 5.54, Curves())
        return np.array([x1, x[1], x3, x4, *x[4:], *a[:, 0], x1 - x3, 5.54 - x1 - x4])

    at, step = np.array(list(x.values())), 1e-6
    # central differences are good to 1e−6² of third derivatives of up to 1e3, and to 2⁻⁵²/1e−6
    J = np.stack([(estimated(at + d) - estimated(at - d)) / (2 * step) for d in step * np.eye(7)], axis=1)
    np.testing.assert_allclose(list(found.values()), np.sqrt(np.diagonal(J @ P @ J.T)), rtol=1e-6)


def test_without_a_covariance_nobody_tells_how_sure_it_is(proportional: Block) -> None:
    assert not [name for name in estimator(proportional).y if name in SPREADS]
    assert set(COVARIANCES) <= set(kalman().y)
