"""From a matrix to a verdict: its rank, its null directions, the coordinates in them, and the tolerance."""

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from hillobs.observers.observability import judge, ranks_of

factors = st.integers(1, 4).flatmap(
    lambda r: st.tuples(
        *(
            st.lists(st.lists(st.integers(-2, 2), min_size=r, max_size=r), min_size=1, max_size=m)
            for m in (6, 5)  # rows, coordinates
        )
    )
)


@settings(max_examples=150)
@given(factors)
def test_column_deletion_names_the_coordinates_of_the_kernel(pair_: tuple[list[list[int]], list[list[int]]]) -> None:
    left, right = (np.array(part) for part in pair_)
    M = left @ right.T
    exact = sympy.Matrix(M.tolist())
    names = [f"s{i}" for i in range(M.shape[1])]
    v = judge(M.astype(float), names, dict.fromkeys(names, 1.0), 1)
    basis = exact.nullspace()
    assert v.rank == exact.rank()
    assert v.ranks == tuple(exact[: k + 1, :].rank() for k in range(len(M)))
    touched = {name for i, name in enumerate(names) if any(vector[i] != 0 for vector in basis)}
    assert set(v.unobservable) == touched
    assert {name for direction in v.null_directions for name in direction} == touched
    assert len(v.null_directions) == len(basis)
    for direction in v.null_directions:
        moved = M @ np.array([direction.get(name, 0.0) for name in names])
        assert np.abs(moved).max() <= 1e-4
        assert max(abs(part) for part in direction.values()) == 1.0


def test_the_default_tolerance_is_relative_to_the_largest() -> None:
    """99 × (1, 0) and (1, ε): singular values 10 and 0.995 ε."""
    for epsilon, rank in ((5e-9, 1), (2e-8, 2)):
        M = np.array([*[[1.0, 0.0]] * 99, [1.0, epsilon]])
        assert judge(M, ["a", "b"], {"a": 1.0, "b": 1.0}, 1).rank == rank
        assert ranks_of(np.stack([M, 0 * M, M]), [1.0, 1.0], 1).tolist() == [rank, 0, rank]


def test_the_tolerance_decides() -> None:
    """(1, 0; 1, ε): singular values √2 and ε/√2 (rows normalised), their ratio ε/2."""
    for tolerance, rank in ((4e-7, 2), (6e-7, 1)):
        v = judge(np.array([[1.0, 0.0], [1.0, 1e-6]]), ["a", "b"], {"a": 1.0, "b": 1.0}, 1, tolerance)
        assert v.rank == rank
        assert v.singular_values == pytest.approx([np.sqrt(2), 1e-6 / np.sqrt(2)], rel=1e-6)


@given(st.lists(st.floats(0.01, 100), min_size=3, max_size=3))
def test_null_directions_are_per_typical_size(size: list[float]) -> None:
    """M = (1, −1, 0): the kernel (1, 1, 0) is (1/size₁, 1/size₂, 0) in typical sizes."""
    v = judge(np.array([[1.0, -1.0, 0.0], [0.0, 0.0, 1.0]]), ["a", "b", "c"], dict(zip("abc", size, strict=True)), 1)
    assert v.unobservable == ("a", "b")
    (direction,) = v.null_directions
    assert direction["a"] * size[0] == pytest.approx(direction["b"] * size[1], rel=1e-2)


def test_a_matrix_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ValueError, match="finite"):
        judge(np.array([[1.0, 0.0], [np.nan, 1.0]]), ["a", "b"], {"a": 1.0, "b": 1.0}, 1)


def test_column_deletion_does_not_name_a_coordinate_that_is_seen() -> None:
    """h = (a + 1e−11 b, a + 2e−11 b): a is seen, b is not; without a what is left of b counts as rank 1."""
    v = judge(np.array([[1.0, 1e-11], [1.0, 2e-11]]), ["a", "b"], {"a": 1.0, "b": 1.0}, 1)
    assert v.rank == 1
    assert v.unobservable == ("b",)
