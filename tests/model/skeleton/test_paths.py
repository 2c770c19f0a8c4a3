"""Muscle lengths over the joints: OpenSim's order of coefficients, moment arms, units."""

import casadi as ca
import numpy as np
import pytest

from hillobs.model.skeleton.paths import Path, constant_moment_arms, moment_arms, polynomial
from hillobs.model.skeleton.tree import TreeError


def value(path: Path, **at: float) -> float:
    q = {name: ca.SX.sym(name) for name in at}
    return float(ca.Function("L", list(q.values()), [path.length(q)])(*at.values()))


def test_the_last_coordinate_rises_fastest() -> None:
    """Order 3 of two: 00 01 02 03 10 11 12 20 21 30."""
    coefficients = [10.0**-k for k in range(10)]
    exponents = [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (3, 0)]
    a, b = 0.7, -1.3
    expected = sum(c * a**i * b**j for c, (i, j) in zip(coefficients, exponents, strict=True))
    assert value(polynomial(["a", "b"], 3, coefficients), b=b, a=a) == pytest.approx(expected, rel=1e-14)


def test_moment_arms_are_minus_the_slopes() -> None:
    path = polynomial(["a", "b"], 2, [0.3, 0.02, -0.01, 0.03, 0.005, -0.02])
    q = ca.SX.sym("q", 2)
    R = ca.Function("R", [q], [moment_arms(path.length({"a": q[0], "b": q[1]}), q)])
    at, step = np.array([0.4, -0.8]), 1e-5
    for j, e in enumerate(np.eye(2)):
        low, high = (value(path, a=x[0], b=x[1]) for x in (at - step * e, at + step * e))
        # the third derivatives of a polynomial of order 2 are 0: only rounding is left
        assert float(R(at)[j]) == pytest.approx(-(high - low) / (2 * step), abs=1e-10)
    arms = constant_moment_arms(0.2, {"a": 0.03, "b": -0.01})
    assert value(arms, a=0.5, b=2.0) == pytest.approx(0.2 - 0.03 * 0.5 + 0.01 * 2.0)


def test_rounding_of_a_fit_is_dropped() -> None:
    assert list(polynomial(["a", "b"], 2, [0.3, 0.02, 1e-17, 0.03, -1e-17, 0]).terms) == [(0, 0), (0, 1), (1, 0)]


def test_another_unit_of_length_and_of_a_slider() -> None:
    path = polynomial(["a", "b"], 2, [0.3, 0.02, -0.01, 0.03, 0.005, -0.02])
    scaled = path.scaled(0.1, {"a": 0.1, "b": 1.0})
    assert value(scaled, a=0.4 / 0.1, b=-0.8) == pytest.approx(value(path, a=0.4, b=-0.8) / 0.1)


def test_a_wrong_number_of_coefficients_is_one_sentence() -> None:
    with pytest.raises(TreeError, match="a polynomial of order 2 in a, b has 6 coefficients, not 5"):
        polynomial(["a", "b"], 2, [1.0] * 5)
    with pytest.raises(TreeError, match="the order of a polynomial must be at least 0, not -1"):
        polynomial(["a"], -1, [])
