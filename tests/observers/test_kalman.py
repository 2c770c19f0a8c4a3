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
from hillobs.codegen.filters import CompiledBank
from hillobs.model.block import Block, Symbols, symbols
from hillobs.model.curves import NGUYEN2019, tendon_parameters
from hillobs.model.wiring import rename, wire
from hillobs.observers.kalman.constant import KALMAN_CONSTANT, butterworth
from hillobs.observers.kalman.filter import kalman
from hillobs.observers.kalman.motion import Motion
from hillobs.observers.kalman.states import ENTRIES, INDEX, MEAN, QUANTITIES, covariance
from hillobs.observers.slopes import tendon_slopes
from hillobs.observers.spread import COVARIANCES, SPREADS, entry, spread
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
    P = np.zeros((len(t), len(INDEX), len(INDEX)))
    for place, name in enumerate(ENTRIES, start=len(MEAN)):
        i, j = (INDEX[part] for part in name.split(".")[1:])
        P[:, i, j] = P[:, j, i] = found[:, place]
    return found[:, : len(MEAN)], P


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
@given(
    p=st.tuples(*[st.floats(0.5, 60)] * 2), m=st.floats(1e-3, 1e3), T=st.floats(1e-4, 0.7)
)
def test_the_motion_in_closed_form_is_the_exponential(p: tuple[float, float], m: float, T: float) -> None:
    # beyond ΩT = π the tendons count as softer
    softer = min(1.0, np.pi**2 * m / (sum(p) * T**2))
    expected = exact(softer * p[0], softer * p[1], m, T)
    np.testing.assert_allclose(motion(*p, m, T), expected, rtol=1e-11, atol=1e-13 * np.abs(expected).max())


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
        P = np.zeros((len(t), len(INDEX), len(INDEX)))
        for place, name in enumerate(ENTRIES, start=len(MEAN)):
            i, j = (INDEX[part] for part in name.split(".")[1:])
            P[:, i, j] = P[:, j, i] = found[:, place]
        used = in_use(Model())
        assert_positive(P[:, used][:, :, used])
