"""As many steps between two samples as an observer's rates ask for, or a sentence."""

import dataclasses
import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.model.block import Block, Parameter, Symbols, symbols
from hillobs.model.system import PAIR
from hillobs.observers import Observer
from hillobs.studies.estimate.substeps import substeps
from hillobs.studies.files.errors import ScenarioError
from known_motion import steps


def rk4(z: np.ndarray) -> np.ndarray:
    return np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24)


@given(
    pair=st.tuples(st.floats(0.05, 5), st.floats(0, 5)),
    real=st.floats(0.05, 5),
    eps=st.floats(0.01, 1),
    T=st.floats(0.01, 1),
)
def test_with_any_stable_injections_the_steps_of_the_high_gain_observer_are_stable(
    pair: tuple[float, float], real: float, eps: float, T: float
) -> None:
    poles = np.array([complex(-pair[0], pair[1]), complex(-pair[0], -pair[1]), -real])
    h11, h12, h13 = np.poly(poles)[1:].real
    given = {"h11": h11, "h12": h12, "h13": h13, "eps_h": eps, "eps_L": 10.0}
    n = steps("high_gain", given, T)
    assert (rk4(poles / eps * T / n) < 1).all()


def test_gains_by_hand_are_what_counts() -> None:
    T = 0.01
    # 1.1/0.01/2.5, with the second layer following the first
    assert steps("sliding_mode", {"delta_s": 0.001}, T) == 5
    assert steps("sliding_mode", {"delta_s": 0.001, "delta_L": 0.1}, T) == 2
    assert steps("adaptive_sliding_mode", {}, T) == math.ceil((20 + 0.5) / 0.01 * T / 2.5)
    assert steps("high_gain", {"eps_h": 0.001}, T) == math.ceil(T / 0.75e-3)
    assert steps("high_gain_3", {"eps_L": 0.002}, T) == math.ceil(T / 1.5e-3)


@pytest.mark.parametrize(
    ("observer", "given", "words"),
    [
        ("sliding_mode", {"delta_L": 0.0}, "sliding_mode.delta_L = 0 has no fastest rate"),
        (
            "adaptive_sliding_mode",
            {"l0": 0.0, "delta_1": 0.0},
            "l0 and adaptive_sliding_mode.delta_1 = 0 has no fastest",
        ),
        ("sliding_mode", {"tau_s": 1e-9}, "too fast for samples τ = 0.01 apart"),
        ("high_gain", {"eps_h": 5e-324}, "too fast for samples τ = 0.01 apart: they ask for inf steps"),
    ],
)
def test_gains_that_no_steps_can_follow_are_refused(observer: str, given: dict[str, float], words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        steps(observer, given, 0.01)


def linear(A: np.ndarray) -> Block:
    """ẋ = A x, whose start depends on a number and on what is seen."""
    x, u = symbols(f"x{i}" for i in range(len(A))), symbols("y1")
    parameters = {"factor": Parameter(1.0, "of all rates", "this test")}
    p = symbols(parameters)
    dx = Symbols(zip(x, ca.vertsplit(p.factor * ca.DM(A) @ x.vector()), strict=True))
    return Block("linear", x=x, u=u, p=p, parameters=parameters, dx=dx, x0=Symbols(x0=p.factor * u.y1))


@pytest.mark.parametrize("rates", [(-3.0, -80.0), (-3.0, 2.0), (0.0, 0.0)])
def test_an_observer_that_tells_no_rates_is_as_fast_as_its_largest_eigenvalue(rates: tuple[float, float]) -> None:
    turn = np.array([[3.0, 1.0], [-1.0, 2.0]])
    block = linear(turn @ np.diag(rates) @ np.linalg.inv(turn))
    unregistered, T = Observer("mine", whole=lambda: block), 0.1
    for factor in (1.0, 7.0):
        n = substeps(unregistered, PAIR, block, {"factor": factor}, {"y1": 2.6}, T)
        assert n == max(1, math.ceil(factor * max(map(abs, rates)) * T / 2.5 - 1e-6))
    turning = linear(np.array([[0.0, 40.0], [-40.0, 0.0]]))
    assert substeps(unregistered, PAIR, turning, {"factor": 1.0}, {"y1": 2.6}, T) == 2


def test_the_slope_where_it_starts_counts() -> None:
    block = linear(-np.eye(1))
    curved = dataclasses.replace(block, dx=Symbols(x0=-(block.x.x0**3)))
    # ∂ẋ/∂x = −3x², x(0) = y₁
    assert substeps(Observer("mine", whole=lambda: curved), PAIR, curved, {"factor": 1.0}, {"y1": 10.0}, 0.1) == 12
    wild = dataclasses.replace(block, dx=Symbols(x0=ca.sqrt(block.x.x0)))
    with pytest.raises(ScenarioError, match=r"linear are too fast .* nan steps"):
        substeps(Observer("mine", whole=lambda: wild), PAIR, wild, {"factor": 1.0}, {"y1": -1.0}, 0.1)
