"""Small systems whose unobservable directions are known in closed form."""

import numpy as np
import pytest
from scipy.linalg import orth

from hillobs.model.block import Block, Parameter, Symbols, symbols
from hillobs.observers.observability import judge, observability_matrix
from observed_systems import judged, kernel_of, linear, same_space, simple


@pytest.mark.parametrize("seed", range(8))
def test_a_known_unobservable_mode_is_found(seed: int) -> None:
    """A = T diag(λ) T⁻¹ with C T e_j = 0: the direction T e_j leaves no trace."""
    random = np.random.default_rng(seed)
    T = random.normal(size=(4, 4))
    T[seed % 3, 1] = 0  # a coordinate that the mode does not touch
    modes = np.array([-1.0, 0.5, 1.5, -2.0])
    C = random.normal(size=(1, 4))
    C[0, 1] = 0
    inverse = np.linalg.inv(T)
    v = judged(linear(T @ np.diag(modes) @ inverse, C @ inverse), 3, [0.0] * 4)
    assert v.rank == 3
    assert v.unobservable == tuple(f"s{i}" for i in range(4) if i != seed % 3)
    assert same_space(kernel_of(v), orth(T[:, 1:2]), 1e-5)


def test_a_conserved_radius_hides_the_angle() -> None:
    """ẋ = −y, ẏ = x, h = x² + y² is constant: at (3, 4) the direction (−4, 3) is lost."""
    circle = simple(lambda s: {"x": -s.y, "y": s.x}, lambda s: {"h": s.x**2 + s.y**2}, "x y")
    v = judged(circle, 4, [3.0, 4.0])
    assert v.ranks == (1, 1, 1, 1, 1)
    assert v.null_directions == ({"x": 1.0, "y": -0.75},)


def test_a_point_may_need_more_than_n_minus_1_orders() -> None:
    """ẋ = 1, θ̇ = 0, h = (x, θ x⁴): ∂L_f^j(θx⁴)/∂θ = 4!/(4−j)! x^(4−j), at x = 0 not 0 for j = 4 only."""
    late = simple(lambda s: {"x": 1, "theta": 0}, lambda s: {"x": s.x, "h": s.theta * s.x**4}, "x theta")
    assert judged(late, 6, [0.0, 0.7]).ranks == (1, 1, 1, 1, 2, 2, 2)
    assert judged(late, 1, [0.0, 0.7]).unobservable == ("theta",)
    assert judged(late, 1, [0.5, 0.7]).full
    # ẋ = 1, h = x³ at 0: 3x² = 0, 6x = 0, 6
    alone = simple(lambda s: {"x": 1}, lambda s: {"h": s.x**3}, "x")
    assert judged(alone, 2, [0.0]).ranks == (0, 0, 1)
    assert judged(alone, 1, [0.0]).null_directions == ({"x": 1.0},)


def test_parameters_enter() -> None:
    """ẋ = k v, v̇ = 0, h = x: M = (1, 0; 0, k)."""
    x, p = symbols("x v"), symbols("k")
    described = {"k": Parameter(2.0, "gain", "this test")}
    b = Block("gain", x=x, p=p, parameters=described, dx=Symbols(x=p.k * x.v, v=0), y=Symbols(h=x.x))
    f = observability_matrix(b, ["h"], 1)
    for k, rank, lost in ((2.0, 2, ()), (0.0, 1, ("v",))):
        assert np.array(f([1, 1], [], [k])).tolist() == [[1, 0], [0, k]]
        v = judge(np.array(f([1, 1], [], [k])), ["x", "v"], {"x": 1, "v": 1}, 1)
        assert (v.rank, v.unobservable) == (rank, lost)


def test_only_products_of_unknown_factors_are_seen() -> None:
    """ẋ = −a b x, h = x: a and b are lost, their product is not; the direction is (a, −b)."""
    decay = simple(lambda s: {"x": -s.a * s.b * s.x, "a": 0, "b": 0}, lambda s: {"h": s.x}, "x a b")
    v = judged(decay, 4, [1.0, 2.0, 0.5])
    assert (v.rank, v.unobservable) == (2, ("a", "b"))
    assert same_space(kernel_of(v), orth(np.array([[0.0], [2.0], [-0.5]])), 1e-5)


def test_rounding_adds_no_rank() -> None:
    """A² = 0 in oblique coordinates: C A² is 0, in doubles 1e−17; the rank is 2 of 3."""
    T = np.random.default_rng(3).normal(size=(3, 3))
    inverse = np.linalg.inv(T)
    N = np.zeros((3, 3))
    N[0, 1] = 1
    assert judged(linear(T @ N @ inverse, inverse[:1]), 2, [0.0] * 3).rank == 2
