"""Observability: ranks by hand, sympy, the textbook, simulated outputs, and laws that hold at every point."""

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from itertools import combinations, permutations

import casadi as ca
import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import null_space, orth

from hillobs.codegen.library import compile_functions
from hillobs.model.block import Block, BlockError, Parameter, Symbols, symbols
from hillobs.model.pair import pair
from hillobs.observers.observability import (
    Verdict,
    augmented,
    decoupling_matrix,
    judge,
    lie_derivatives,
    observability_matrix,
    ranks_of,
    structural_rank,
)
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.observability.information import deviations
from hillobs.studies.observability.map import along, over
from hillobs.studies.observability.point import answer, start_point
from hillobs.studies.observability.question import pose
from hillobs.studies.scenarios.prepare import prepare
from independent import muscle

Array = NDArray[np.float64]
Point = Mapping[str, float]

SENSORS = ("x1", "Phi_S1", "Phi_S2")
UNKNOWN = {"none": (), "none, a": (), "u": ("Delta", "u1", "u2"), "a": ("Delta", "a1", "a2")}
# the typical sizes of docs/observers.md#observability
SIZE = {"a1": 0.5, "a2": 0.1}

TAUT = {"x1": 2.6, "x2": 0.03, "x3": 2.018, "x4": 2.025, "Delta": 0.005, "u1": 0.02, "u2": -0.01, "a1": 0.5, "a2": 0.3}
REGIONS: dict[str, Point] = {
    "both taut": TAUT,
    "toe and linear": {**TAUT, "x1": 2.85, "x3": 2.047, "a1": 0.9, "x4": 2.018, "a2": 0.8},
    "1 slack": {**TAUT, "x3": 1.95},
    "2 slack": {**TAUT, "x4": 1.96},
    "both slack": {**TAUT, "x3": 1.95, "x4": 1.96},
}


@cache
def block(unknown: str, derivatives: int = 0) -> Block:
    return augmented(pair("given" if "a" in unknown else "virtual"), UNKNOWN[unknown], derivatives)


@cache
def function(unknown: str, outputs: tuple[str, ...], order: int, derivatives: int = 0) -> ca.Function:
    return observability_matrix(block(unknown, derivatives), outputs, order)


def numbers(b: Block) -> list[float]:
    return [parameter.default for parameter in b.parameters.values()]


def evaluate(b: Block, f: ca.Function, point: Point) -> Array:
    return np.array(f([point.get(n, 0.003) for n in b.x], [point[n] for n in b.u], numbers(b)))


def matrix(unknown: str, outputs: tuple[str, ...], order: int, point: Point, derivatives: int = 0) -> Array:
    return evaluate(block(unknown, derivatives), function(unknown, outputs, order, derivatives), point)


def sizes(b: Block) -> dict[str, float]:
    return {name: SIZE.get(name, 0.01) for name in b.x}


def verdict(unknown: str, point: Point, outputs: tuple[str, ...] = SENSORS, order: int = 6) -> Verdict:
    b = block(unknown)
    return judge(matrix(unknown, outputs, order, point), list(b.x), sizes(b), len(outputs))


def simple(dx: Callable[[Symbols], Mapping[str, object]], y: Callable[[Symbols], Mapping[str, object]], names: str):
    x = symbols(names)
    return Block("simple", x=x, dx=Symbols(dx(x)), y=Symbols(y(x)))


def judged(b: Block, order: int, at: Sequence[float], outputs: Sequence[str] = ()) -> Verdict:
    outputs = outputs or list(b.y)
    f = observability_matrix(b, outputs, order)
    return judge(np.array(f(at, [], numbers(b))), list(b.x), dict.fromkeys(b.x, 1.0), len(outputs))


def kernel_of(v: Verdict) -> Array:
    """The null directions as orthonormal columns."""
    if not v.null_directions:
        return np.zeros((len(v.coordinates), 0))
    return orth(np.array([[d.get(n, 0.0) for n in v.coordinates] for d in v.null_directions]).T)


def same_space(left: Array, right: Array, tolerance: float) -> bool:
    return left.shape == right.shape and bool(np.allclose(left @ left.T, right @ right.T, atol=tolerance))


# ---------------------------------------------------------------- the ranks in docs/observers.md#observability


def by_order(*ranks: int, of: int = 7) -> tuple[int, ...]:
    return (*ranks, *[ranks[-1]] * (of - len(ranks)))


TABLE = {
    ("none", "both taut"): (by_order(3, 4, of=4), ()),
    ("none", "toe and linear"): (by_order(3, 4, of=4), ()),
    ("none", "1 slack"): (by_order(2, 3, of=4), ("x3",)),
    ("none", "2 slack"): (by_order(2, 3, of=4), ("x4",)),
    ("none", "both slack"): (by_order(1, 2, of=4), ("x3", "x4")),
    ("none, a", "both taut"): (by_order(3, 4, of=4), ()),
    ("none, a", "1 slack"): (by_order(2, 3, of=4), ("x3",)),
    ("none, a", "2 slack"): (by_order(2, 3, of=4), ("x4",)),
    ("none, a", "both slack"): (by_order(1, 2, of=4), ("x3", "x4")),
    ("u", "both taut"): (by_order(3, 6, 7), ()),
    ("u", "toe and linear"): (by_order(3, 6, 7), ()),
    ("u", "1 slack"): (by_order(2, 4, 5), ("x3", "u1")),
    ("u", "2 slack"): (by_order(2, 4, 5), ("x4", "u2")),
    ("u", "both slack"): (by_order(1, 2, 3), ("x3", "x4", "u1", "u2")),
    ("a", "both taut"): (by_order(3, 6, 7), ()),
    ("a", "toe and linear"): (by_order(3, 6, 7), ()),
    ("a", "1 slack"): (by_order(2, 4, 5), ("x3", "a1")),
    ("a", "2 slack"): (by_order(2, 4, 5), ("x4", "a2")),
    ("a", "both slack"): (by_order(1, 2, 3), ("x3", "x4", "a1", "a2")),
}


@pytest.mark.parametrize(("unknown", "region"), TABLE)
def test_the_table_of_ranks(unknown: str, region: str) -> None:
    ranks, lost = TABLE[unknown, region]
    v = verdict(unknown, REGIONS[region], order=len(ranks) - 1)
    assert v.ranks == ranks
    assert (v.rank, v.unobservable, v.full) == (ranks[-1], lost, not lost)
    # each null direction is one lost coordinate and nothing else, or a mixture of the lost ones
    assert {name for direction in v.null_directions for name in direction} == set(lost)
    assert len(v.null_directions) == len(lost) == len(ranks) - v.rank


@pytest.mark.parametrize("unknown", UNKNOWN)
def test_the_pattern_alone_always_says_full(unknown: str) -> None:
    n = len(block(unknown).x)
    assert structural_rank(block(unknown), SENSORS, n - 1) == n


def test_the_pattern_knows_what_is_never_seen() -> None:
    assert [structural_rank(block("u"), SENSORS, k) for k in range(3)] == [3, 6, 7]
    # without a length the pattern has no x₁ at all
    assert structural_rank(block("u"), ("Phi_S1", "Phi_S2"), 6) == 6


def test_the_ranks_with_unknown_signals() -> None:
    """The unknowns with two derivatives each, 13 coordinates."""
    b = block("u", 2)
    assert len(b.x) == 13
    one = (2, 4, 6, 8)
    expected = {"both taut": (3, 6, 9, 12), "1 slack": one, "2 slack": one, "both slack": (1, 2, 3, 4)}
    # muscle 1 slack, orders 0, 0–1, 0–2, 0–3
    seen = ["x1 x4", "x1 x2 x4 u2", "x1 x2 x4 Delta u2", "x1 x2 x4 Delta u2"]
    for region, ranks in expected.items():
        M = matrix("u", SENSORS, 3, REGIONS[region], derivatives=2)
        v = judge(M, list(b.x), sizes(b), 3)
        assert v.ranks == ranks
        if region == "1 slack":
            for k, names in enumerate(seen, start=1):
                lost = judge(M[: 3 * k], list(b.x), sizes(b), 3).unobservable
                assert tuple(name for name in block("u").x if name not in lost) == tuple(names.split())
    # one order more determines the last coordinate, Δ″
    assert judge(matrix("u", SENSORS, 4, TAUT, derivatives=2), list(b.x), sizes(b), 3).full


# ---------------------------------------------------------------- oracles


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
        found = matrix(unknown, SENSORS, order, dict(zip(block(unknown).x, at, strict=True)))
        assert found == pytest.approx(exact, rel=1e-9, abs=1e-9)


def linear(A: Array, C: Array) -> Block:
    x = symbols(f"s{i}" for i in range(len(A)))
    dx, y = ca.DM(A) @ x.vector(), ca.DM(C) @ x.vector()
    return Block(
        "linear",
        x=x,
        dx=Symbols({name: dx[i] for i, name in enumerate(x)}),
        y=Symbols({f"y{i}": y[i] for i in range(len(C))}),
    )


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


def outputs_of(unknown: str, start: Array, duration: float, sensors: Sequence[str]) -> Array:
    """Simulated outputs at 12 times for the columns of `start`, (Δ, w₁, w₂) constant, by docs/model.md#plant."""

    def rhs(_: float, flat: Array) -> Array:
        x1, x2, x3, x4, Delta, *w = X = flat.reshape(7, -1)
        tendons = np.stack([x3, x4])
        force = muscle.Phi_S(tendons)
        u = np.stack(w)
        if unknown == "a":
            L_C = muscle.fibres(x1, tendons, 5.54)
            z = (force - muscle.Phi_P(L_C)) / (np.clip(u, 0.01, 1) * muscle.f(L_C))
            u = muscle.g_inv(np.clip(z, 0, 1.45))
        rates = np.zeros_like(X)
        rates[:4] = x2, force[1] - force[0] + Delta, x2 + u[0], -x2 + u[1]
        return rates.ravel()

    times = np.linspace(0, duration, 12)
    run = solve_ivp(rhs, (0, duration), start.ravel(), method="DOP853", t_eval=times, rtol=1e-12, atol=1e-13)
    x1, x2, x3, x4 = run.y.reshape(7, -1, len(times))[:4]
    every = {
        "x1": x1, "x2": x2, "Phi_S1": muscle.Phi_S(x3), "Phi_S2": muscle.Phi_S(x4),
        "L_C1": x1 - x3, "L_C2": 5.54 - x1 - x4,
    }  # fmt: skip
    return np.concatenate([every[name].T for name in sensors])


@pytest.mark.parametrize("sensors", [SENSORS, ("Phi_S1", "Phi_S2"), ("L_C1", "L_C2"), ("x2", "Phi_S1")], ids=str)
@pytest.mark.parametrize(("unknown", "duration"), [("u", 0.5), ("a", 0.3)])
@pytest.mark.parametrize("region", ["both taut", "1 slack", "2 slack", "both slack"])
def test_simulated_outputs_see_the_same(unknown: str, duration: float, region: str, sensors: tuple[str, ...]) -> None:
    """Empirical Gramian W = Σ ΔyᵀΔy: its rank and its kernel."""
    # so far below 2 that the tendons stay slack; a slack muscle driven by a shortens with u = 1
    point = {name: value if value > 2 or name not in ("x3", "x4") else 1.6 for name, value in REGIONS[region].items()}
    b = block(unknown)
    x = np.array([point[name] for name in b.x])
    scale = np.array(list(sizes(b).values()))
    step = 1e-3 * np.diag(scale)
    y = outputs_of(unknown, x[:, None] + np.hstack([step, -step]), duration, sensors)
    # ∂y/∂x by central differences
    sensitivity = (y[:, :7] - y[:, 7:]) / 2e-3
    _, values, right = np.linalg.svd(sensitivity, full_matrices=False)
    v = verdict(unknown, point, sensors)
    if unknown == "a" and sensors in (("L_C1", "L_C2"), ("x2", "Phi_S1")):
        # what f carries only is faint: no kernel of ours may be seen, the converse is not decided by differences
        kernel = kernel_of(v)
        assert np.all(np.abs(sensitivity @ kernel) < 1e-5 * values[0])
        return
    assert np.sum(values > 1e-6 * values[0]) == v.rank
    assert same_space(kernel_of(v), right[v.rank :].T, 1e-3)


# ---------------------------------------------------------------- systems whose answer is known


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


# ---------------------------------------------------------------- decisions are stable

MANY = {"u": 6, "a": 2}  # highest order, compiled


@pytest.fixture(scope="module")
def many() -> Callable[[str, Array], Array]:
    """O at many points, from compiled C."""
    libraries = {unknown: compile_functions([function(unknown, SENSORS, order)]) for unknown, order in MANY.items()}

    def evaluate_many(unknown: str, x: Array) -> Array:
        b = block(unknown)
        (flat,) = libraries[unknown].call("observability", x, np.zeros((len(x), 0)), numbers(b))
        return flat.reshape(len(x), len(b.x), -1).transpose(0, 2, 1)

    return evaluate_many


def force_factors(x: Array) -> Array:
    """z of both muscles at points (x₁ … x₄, Δ, a₁, a₂)."""
    L_C = muscle.fibres(x[:, 0], x[:, 2:4].T, 5.54)
    return (muscle.Phi_S(x[:, 2:4].T) - muscle.Phi_P(L_C)) / (x[:, 5:7].T * muscle.f(L_C))


def points(unknown: str, count: int, seed: int, tendon: tuple[float, float] = (2.004, 2.06)) -> Array:
    random = np.random.default_rng(seed)
    drive = (-0.5, 0.5) if unknown == "u" else (0.05, 0.95)
    ranges = [(2.4, 3.1), (-0.1, 0.1), tendon, tendon, (-0.05, 0.05), drive, drive]
    return np.column_stack([random.uniform(*r, count) for r in ranges])


def free(x: Array) -> NDArray[np.bool_]:
    """Neither muscle's force factor is at its limits 0 and 1.45."""
    z = force_factors(x)
    return np.all((z > 0) & (z < 1.45), axis=0)


def size_list(unknown: str) -> list[float]:
    return list(sizes(block(unknown)).values())


@pytest.mark.numerics
@pytest.mark.parametrize("unknown", MANY)
def test_1000_random_taut_points_are_all_full(unknown: str, many: Callable[[str, Array], Array]) -> None:
    x = points(unknown, 20_000, 1)
    x = (x if unknown == "u" else x[free(x)])[:1000]
    assert len(x) == 1000
    M = many(unknown, x)
    for order, rank in ((0, 3), (1, 6), (2, 7), *([(6, 7)] if unknown == "u" else [])):
        assert np.all(ranks_of(M[:, : 3 * (order + 1)], size_list(unknown), 3) == rank), order
    # smallest of the thousand: 8.8e-3 (u, orders 0–6) and 1.5e-3 (a, orders 0–2)
    v = [judge(one, list(block(unknown).x), sizes(block(unknown)), 3) for one in M[:100]]
    assert all(one.full and one.singular_values[-1] > 1e-4 * one.singular_values[0] for one in v)


@pytest.mark.numerics
def test_a_limited_force_factor_hides_its_activation(many: Callable[[str, Array], Array]) -> None:
    """At a limit of z the velocity does not depend on a: the taut set alone is not enough for the a form."""
    x = points("a", 2000, 2)
    x = x[~free(x)]
    z = force_factors(x)
    limited = (z <= 0) | (z >= 1.45)
    M = many("a", x)
    assert np.all(ranks_of(M, size_list("a"), 3) == 7 - limited.sum(axis=0))
    for one, hidden in list(zip(M, limited.T, strict=True))[:50]:
        lost = judge(one, list(block("a").x), sizes(block("a")), 3).unobservable
        assert lost == tuple(name for name, h in zip(("a1", "a2"), hidden, strict=True) if h)


@pytest.mark.numerics
@pytest.mark.parametrize("unknown", MANY)
@pytest.mark.parametrize("slack", [(0,), (1,), (0, 1)])
def test_random_slack_points_lose_two_each(
    unknown: str, slack: tuple[int, ...], many: Callable[[str, Array], Array]
) -> None:
    x = points(unknown, 20_000, 3)
    if unknown == "a":
        x = x[free(x)]
    x = x[:300]
    for j in slack:
        x[:, 2 + j] = np.random.default_rng(j).uniform(1.7, 2.0, len(x))
    if unknown == "a":
        # the other muscle's state is as before: still free
        assert np.all(force_factors(x)[[j for j in (0, 1) if j not in slack]] > 0)
    M = many(unknown, x)
    assert np.all(ranks_of(M, size_list(unknown), 3) == 7 - 2 * len(slack))
    lost = judge(M[0], list(block(unknown).x), sizes(block(unknown)), 3).unobservable
    assert set(lost) == {name for j in slack for name in (f"x{j + 3}", f"{unknown}{j + 1}")}


@pytest.mark.numerics
@pytest.mark.parametrize(("unknown", "order", "nearest"), [("u", 6, 1e-15), ("u", 2, 3e-9), ("a", 2, 3e-4)])
def test_how_near_the_edge_a_taut_tendon_is_seen(
    unknown: str, order: int, nearest: float, many: Callable[[str, Array], Array]
) -> None:
    """x₃ − 2 (and x₄ − 2) down to which the rank is 7; orders up to 2 fade as Φ′/Φ″, in the a form also as z."""
    for both in (False, True):
        x = points(unknown, 20_000, 4)
        x[:, 2] = 2 + nearest
        if both:
            x[:, 3] = 2 + nearest
        x = (x if unknown == "u" else x[free(x)])[:300]
        assert len(x) == 300
        assert np.all(ranks_of(many(unknown, x)[:, : 3 * (order + 1)], size_list(unknown), 3) == 7)


def test_at_the_edge_itself_two_orders_see_nothing() -> None:
    """Φ = Φ′ = Φ″ = 0 at 2."""
    v = verdict("u", {**TAUT, "x3": 2.0}, order=2)
    assert v.ranks == (2, 4, 6)
    assert "u1" in v.unobservable or "x3" in v.unobservable


def test_at_the_edge_both_sides_are_asked_and_the_lower_counts() -> None:
    """At x₃ = 2 the derivatives of O belong to neither side: from the slack one neither x₃ nor u₁ leaves a trace."""
    question = pose(prepare("paper-clean", None, {}), unknown="u")
    seen = answer(question, {**TAUT, "x2": -0.03, "u1": -0.02, "x3": 2.0})
    assert seen.kinks == {"x3": (5, 7)}
    assert (seen.verdict.rank, seen.verdict.unobservable) == (5, ("x3", "u1"))
    assert answer(question, {**TAUT, "x3": 2.018}).kinks == {}


def test_the_accuracy_is_that_of_a_linear_system_in_closed_form() -> None:
    """ẋ = v, v̇ = 0, position sampled: the variance of a line fitted to N samples."""
    x = symbols("x v")
    line = Block("line", x=x, dx=Symbols(x=x.v, v=x.x * 0), y=Symbols(x=x.x))
    period, samples, half_width = 0.01, 100, 1e-3
    t = period * np.arange(samples)
    design = np.stack([np.ones(samples), t], axis=1)
    expected = np.sqrt(np.diag(np.linalg.inv(design.T @ design)) * half_width**2 / 3)
    found = deviations(line, ([0.0, 0.0], []), [], {"x": half_width}, {"x": 1.0, "v": 1.0}, period)
    np.testing.assert_allclose(list(found.values()), expected, rtol=1e-9)


def test_what_leaves_no_trace_has_no_accuracy() -> None:
    """Both tendons slack for good: neither length is known, however long one waits."""
    question = pose(prepare("paper-clean", None, {}), unknown="u")
    found = answer(question, {**TAUT, "x3": 1.9, "x4": 1.9, "u1": 0.0, "u2": 0.0, "x2": 0.0, "Delta": 0.0}).deviations
    assert {name for name, value in found.items() if np.isinf(value)} == {"x3", "x4", "u1", "u2"}
    assert all(value < 1e-2 for name, value in found.items() if name in ("x1", "x2", "Delta"))


def decision(v: Verdict) -> tuple[object, ...]:
    return v.rank, v.ranks, v.unobservable


def rescaled(b: Block, kind: str, name: str, c: float) -> Block:
    """The same system, one state or output counted in another unit: old = c · new."""
    if kind == "output":
        return dataclasses.replace(b, y=Symbols({**b.y, name: b.y[name] / c}))
    new = ca.SX.sym(name)

    def change(entries: Symbols) -> Symbols:
        if not entries:
            return entries
        return Symbols(zip(entries, ca.substitute(list(entries.values()), [b.x[name]], [c * new]), strict=True))

    changed = {group: change(getattr(b, group)) for group in ("y", "dx", "guards", "domain")}
    changed["dx"][name] = changed["dx"][name] / c
    return dataclasses.replace(b, x=Symbols({**b.x, name: new}), **changed)


QUANTITIES = [("state", n) for n in ("x1", "x2", "x3", "x4", "Delta", "1", "2")] + [("output", n) for n in SENSORS]


@pytest.mark.parametrize(("unknown", "order"), [("u", 6), ("a", 2)])
@pytest.mark.parametrize(("kind", "name"), QUANTITIES)
def test_units_do_not_matter(unknown: str, order: int, kind: str, name: str) -> None:
    name = f"{unknown}{name}" if name in "12" else name
    b = block(unknown)
    for c in (1e-6, 1e6):
        other = rescaled(b, kind, name, c)
        f = observability_matrix(other, SENSORS, order)
        size = sizes(b)
        if kind == "state":
            size[name] /= c
        for region in ("both taut", "1 slack"):
            at = dict(REGIONS[region])
            expected = verdict(unknown, at, order=order)
            if kind == "state":
                at[name] /= c
            found = judge(evaluate(other, f, at), list(other.x), size, 3)
            assert decision(found) == decision(expected)
            assert found.singular_values == pytest.approx(expected.singular_values, rel=1e-6, abs=1e-10)
            assert same_space(kernel_of(found), kernel_of(expected), 1e-5)


@pytest.mark.parametrize(("unknown", "order"), [("none", 3), ("u", 6), ("a", 2)])
def test_the_order_of_the_sensors_does_not_matter(unknown: str, order: int) -> None:
    for region in REGIONS.values():
        expected = verdict(unknown, region, order=order)
        for outputs in permutations(SENSORS):
            found = verdict(unknown, region, outputs, order)
            assert decision(found) == decision(expected)
            assert found.singular_values == pytest.approx(expected.singular_values, rel=1e-9, abs=1e-13)


@given(st.lists(st.floats(1.9, 2.2), min_size=2, max_size=2), st.floats(-0.2, 0.2), st.floats(-0.5, 0.5))
def test_the_determinant_is_that_of_the_slopes(lengths: list[float], x2: float, u: float) -> None:
    """|det| = Φ′²_S1 Φ′²_S2: 0 when slack, and fading in the toe."""
    b = block("u")
    at = {**TAUT, "x2": x2, "u1": u, "x3": lengths[0], "x4": lengths[1]}
    D = evaluate(b, decoupling(), at)
    assert D.shape == (7, 7)
    slopes = np.array([float(muscle.dPhi_S(np.array([L]))[0]) for L in lengths])
    assert abs(np.linalg.det(D)) == pytest.approx(np.prod(slopes**2), rel=1e-9)
    if min(lengths) <= 2:
        assert np.linalg.det(D) == 0


@cache
def decoupling() -> ca.Function:
    return decoupling_matrix(block("u"), SENSORS, UNKNOWN["u"])


# ---------------------------------------------------------------- which sensors

LABORATORY = ("x1", "x2", "Phi_S1", "Phi_S2", "L_C1", "L_C2")
SUBSETS = [subset for k in range(1, 7) for subset in combinations(LABORATORY, k)]


@cache
def verdicts(unknown: str, region: str) -> dict[tuple[str, ...], Verdict]:
    b = block(unknown)
    M = matrix(unknown, LABORATORY, 6, REGIONS[region]).reshape(7, 6, 7)

    def rows(subset: Iterable[str]) -> Array:
        return M[:, [LABORATORY.index(name) for name in subset]].reshape(-1, 7)

    return {subset: judge(rows(subset), list(b.x), sizes(b), len(subset)) for subset in SUBSETS}


@pytest.mark.parametrize("region", REGIONS)
@pytest.mark.parametrize("unknown", ["u", "a"])
def test_a_further_sensor_never_hides_anything(unknown: str, region: str) -> None:
    found = verdicts(unknown, region)
    assert len(found) == 63
    for subset, v in found.items():
        for name in LABORATORY:
            if name not in subset:
                more = tuple(n for n in LABORATORY if n in (*subset, name))
                assert found[more].rank >= v.rank, (subset, name)


@pytest.mark.parametrize("subset", [("x1",), ("Phi_S1", "Phi_S2"), ("x2", "Phi_S2", "L_C1")], ids=str)
def test_rows_belong_to_their_sensor(subset: tuple[str, ...]) -> None:
    for unknown in ("u", "a"):
        alone, among = verdict(unknown, TAUT, subset), verdicts(unknown, "both taut")[subset]
        assert (alone.ranks, alone.unobservable) == (among.ranks, among.unobservable)


def test_what_each_set_of_sensors_sees_with_u_unknown() -> None:
    """By hand: L̇_C = −u is no news of the mass, forces see x₂ + u₁ and −x₂ + u₂ only, and only lengths see x₁."""
    for subset, v in verdicts("u", "both taut").items():
        lengths = {"L_C1", "L_C2"} & set(subset)
        movement = {"x2", "Phi_S1", "Phi_S2"} & set(subset)
        if "x1" in subset or (lengths and movement):
            expected: tuple[int, set[str]] = 7, set()
        elif "x2" in subset:
            expected = 6, {"x1"}
        elif movement:
            # the mass and both fibres may drift together: (x₂, u₁, u₂) ∝ (1, −1, 1)
            expected = 5, {"x1", "x2", "u1", "u2"}
        else:
            expected = 2 * len(lengths), {"x1", "x2", "x3", "x4", "Delta", "u1", "u2"} - {f"u{n[-1]}" for n in lengths}
        assert (v.rank, set(v.unobservable)) == expected, subset
    drift = np.array([[1.0, 0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, -1, 1]]).T
    assert same_space(kernel_of(verdicts("u", "both taut")["Phi_S1", "Phi_S2"]), orth(drift), 1e-5)


def test_the_force_length_curve_carries_the_position_with_a_unknown() -> None:
    """Forces alone: f(x₁ − x₃) tells x₁ where the virtual inputs told nothing; no force, no such news."""
    found = verdicts("a", "both taut")
    assert found["Phi_S1", "Phi_S2"].full
    assert found["x2", "Phi_S1", "Phi_S2"].full
    assert all(v.full for subset, v in found.items() if "x1" in subset)
    # with f = 1 and no parallel element nothing depends on x₁ any more
    flat = [1e9 if name.endswith(".W") else 0.0 if name.endswith(".k_P") else p.default
            for name, p in block("a").parameters.items()]  # fmt: skip
    f = function("a", ("Phi_S1", "Phi_S2"), 6)
    v = judge(np.array(f([TAUT[n] for n in block("a").x], [], flat)), list(block("a").x), sizes(block("a")), 2)
    assert "x1" in v.unobservable


# ---------------------------------------------------------------- column deletion and kernel


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


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize("act", [lie_derivatives, observability_matrix, structural_rank])
def test_bad_outputs_and_orders_are_refused(act: Callable[[Block, Sequence[str], int], object]) -> None:
    plant = pair()
    with pytest.raises(BlockError, match=r"plant: no output F1, F2; there are x1, x2, .*Phi_S1.*taut2"):
        act(plant, ["x1", "F1", "F2"], 3)
    with pytest.raises(BlockError, match=r"without an output nothing can be observed; there are x1, x2, "):
        act(plant, [], 3)
    with pytest.raises(BlockError, match=r"order of the Lie derivatives must be at least 0, not -1"):
        act(plant, SENSORS, -1)


@pytest.mark.parametrize("drive", ["virtual", "given"])
def test_bad_unknowns_are_refused(drive: str) -> None:
    plant = pair(drive)
    valid = ", ".join(plant.u)
    with pytest.raises(BlockError, match=f"plant: no input x3, a9; there are {valid}"):
        augmented(plant, ["Delta", "x3", "a9"])
    with pytest.raises(BlockError, match="order of the unknowns' derivatives must be at least 0, not -1"):
        augmented(plant, ["Delta"], -1)
    with pytest.raises(BlockError, match="no input Delta"):
        augmented(augmented(plant, ["Delta"]), ["Delta"])


def test_a_sensor_list_that_is_one_word_is_refused() -> None:
    with pytest.raises(BlockError, match="no output x, 1"):
        lie_derivatives(pair(), "x1", 1)


# ---------------------------------------------------------------- defects


def test_decoupling_refuses_an_unknown_that_is_no_coordinate() -> None:
    with pytest.raises(BlockError, match=r"u9.*there are x1, "):
        decoupling_matrix(block("u"), SENSORS, ["u9"])


def test_decoupling_refuses_an_empty_list_of_sensors() -> None:
    with pytest.raises(BlockError, match="without an output nothing can be observed"):
        decoupling_matrix(block("u"), [], ["u1"])


def test_a_sampled_state_is_refused() -> None:
    x = symbols("a held")
    sampled = Block("sampled", x=x, dx=Symbols(a=x.held), next=Symbols(held=x.a), y=Symbols(a=x.a))
    with pytest.raises(BlockError, match="held"):
        observability_matrix(sampled, ["a"], 1)


def test_a_matrix_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ValueError, match="finite"):
        judge(np.array([[1.0, 0.0], [np.nan, 1.0]]), ["a", "b"], {"a": 1.0, "b": 1.0}, 1)


def test_column_deletion_does_not_name_a_coordinate_that_is_seen() -> None:
    """h = (a + 1e−11 b, a + 2e−11 b): a is seen, b is not; without a what is left of b counts as rank 1."""
    v = judge(np.array([[1.0, 1e-11], [1.0, 2e-11]]), ["a", "b"], {"a": 1.0, "b": 1.0}, 1)
    assert v.rank == 1
    assert v.unobservable == ("b",)


def test_rounding_adds_no_rank() -> None:
    """A² = 0 in oblique coordinates: C A² is 0, in doubles 1e−17; the rank is 2 of 3."""
    T = np.random.default_rng(3).normal(size=(3, 3))
    inverse = np.linalg.inv(T)
    N = np.zeros((3, 3))
    N[0, 1] = 1
    assert judged(linear(T @ N @ inverse, inverse[:1]), 2, [0.0] * 3).rank == 2


def test_two_tendons_at_their_edges_are_as_bad_as_two_slack_ones() -> None:
    for unknown, lost in (("u", 4), ("a", 4)):
        seen = answer(pose(prepare("paper-clean", None, {}), unknown=unknown), {**TAUT, "x3": 2.0, "x4": 2.0})
        assert len(seen.verdict.unobservable) == lost
        assert set(seen.kinks) >= {"x3", "x4"}


def test_a_steep_slope_is_no_kink() -> None:
    prepared = prepare("challenge", None, {})
    assert answer(pose(prepared, unknown="a"), start_point(prepared)).kinks == {}


def test_a_map_begins_slack_and_takes_the_tolerance() -> None:
    prepared = prepare("paper-clean", None, {})
    question, point = pose(prepared, unknown="u", order=2), start_point(prepared)
    data = over(question, ("x1", "tension"), point, points=24)
    assert (data["rank"].where(data.tension <= 0, drop=True) == 3).all()
    assert (data["rank"].where(data.tension > 0.05, drop=True) == 7).all()
    assert (over(question, ("x3", "x4"), point, points=5, tolerance=0.5)["rank"] < 7).all()


def test_along_a_run_the_rank_falls_exactly_while_a_tendon_is_slack() -> None:
    prepared = prepare("slack", None, {"duration": 8.0})
    data = along(prepared, pose(prepared, unknown="u", order=2))
    slack = (data.taut == 0).sum("muscle")
    np.testing.assert_array_equal(data["rank"], 7 - 2 * slack)
    with pytest.raises(ScenarioError, match="no run to look along: the plant"):
        along(prepare("paper-clean", None, {"initial.x2": -40.0}), pose(prepared))
