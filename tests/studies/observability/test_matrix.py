"""The matrix of Lie derivatives is that of sympy and, for a linear system, that of the textbook."""

from collections.abc import Callable

import mpmath
import numpy as np
import pytest
import sympy
from scipy.linalg import null_space

from hillobs.model.arrays import Array
from hillobs.observers.observability import observability_matrix
from observed_systems import SENSORS, block, judged, kernel_of, linear, matrix, same_space


def quintic() -> Callable[[sympy.Symbol], sympy.Expr]:
    F, toe, k = sympy.Rational(1, 2), sympy.Rational(1, 25), sympy.Rational(192308, 10000)
    D = toe * k
    # Φ_S = s³(A₃ + s(A₄ + s A₅)),  s = (L − 2)/toe
    return lambda L: (s := (L - 2) / toe) ** 3 * ((10 * F - 4 * D) + s * ((-15 * F + 7 * D) + s * (6 * F - 3 * D)))


def by_sympy(unknown: str, order: int) -> Callable[..., mpmath.matrix]:
    """O on the branch where both tendons are in the toe and no limit is active."""
    x1, x2, x3, x4, Delta, w1, w2 = X = sympy.symbols("x1 x2 x3 x4 Delta w1 w2")
    Phi = quintic()
    u = [w1, w2]
    if unknown == "a":
        for j, (L_C, x) in enumerate(((x1 - x3, x3), (sympy.Rational(554, 100) - x1 - x4, x4))):
            # z = Φ_S/(a f) in (0, 1), u = (1 − z)/(1 + z/A), fibres below their optimal length: Φ_P = 0
            z = Phi(x) / (u[j] * sympy.exp(-(((L_C - 1) / sympy.Rational(3, 10)) ** 2)))
            u[j] = (1 - z) / (1 + 4 * z)
    f = [x2, Phi(x4) - Phi(x3) + Delta, x2 + u[0], -x2 + u[1], 0, 0, 0]
    lie = [x1, Phi(x3), Phi(x4)]
    rows = list(lie)
    for _ in range(order):
        lie = [sum(sympy.diff(h, x) * d for x, d in zip(X, f, strict=True)) for h in lie]
        rows += lie
    return sympy.lambdify(X, sympy.Matrix(rows).jacobian(X), "mpmath", cse=True)


@pytest.mark.parametrize(("unknown", "order"), [("u", 3), ("a", 2)])
def test_it_is_the_matrix_of_sympy(unknown: str, order: int) -> None:
    expected = by_sympy(unknown, order)
    random = np.random.default_rng(1)
    drives = ((0.6, 0.9), (0.6, 0.9)) if unknown == "a" else ((-0.5, 0.5), (-0.5, 0.5))
    ranges = ((2.65, 2.75), (-0.1, 0.1), (2.002, 2.012), (2.002, 2.02), (-0.05, 0.05), *drives)
    for _ in range(5):
        at = [random.uniform(*r) for r in ranges]
        with mpmath.workdps(40):
            exact = np.array(expected(*map(mpmath.mpf, at)).tolist(), float)
        computed = matrix(unknown, SENSORS, order, dict(zip(block(unknown).x, at, strict=True)))
        assert computed == pytest.approx(exact, rel=1e-9, abs=1e-9)


def textbook(A: Array, C: Array) -> Array:
    # (C; CA; CA²; …)
    return np.vstack([C @ np.linalg.matrix_power(A, k) for k in range(len(A))])


@pytest.mark.parametrize("seed", range(12))
def test_a_linear_system_has_the_textbooks_matrix(seed: int) -> None:
    random = np.random.default_rng(seed)
    n, q = random.integers(2, 6), random.integers(1, 3)
    A, C = random.normal(size=(n, n)), random.normal(size=(q, n))
    if seed % 2:  # in two parts that do not meet, one of them seen
        half = n // 2
        A[:half, half:] = A[half:, :half] = C[:, half:] = 0
    expected = textbook(A, C)
    b = linear(A, C)
    f = observability_matrix(b, list(b.y), int(n) - 1)
    assert np.array(f(random.normal(size=n), [], [])) == pytest.approx(expected, rel=1e-10, abs=1e-12)
    v = judged(b, int(n) - 1, [0.0] * n)
    assert v.rank == np.linalg.matrix_rank(expected) == (n // 2 if seed % 2 else n)
    assert same_space(kernel_of(v), null_space(expected), 1e-6)
