"""The decision is the same at thousands of random points of a region, by compiled code."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from hillobs.codegen.shared_library import compile_functions
from hillobs.model.arrays import Array
from hillobs.observers.observability import judge, ranks_of
from independent import muscle
from observed_systems import SENSORS, block, function, numbers, sizes

HIGHEST_ORDER = {"u": 6, "a": 2}


@pytest.fixture(scope="module")
def matrices() -> Callable[[str, Array], Array]:
    """O at an array of points, from compiled C."""
    libraries = {
        unknown: compile_functions([function(unknown, SENSORS, order)]) for unknown, order in HIGHEST_ORDER.items()
    }

    def at_points(unknown: str, x: Array) -> Array:
        b = block(unknown)
        (flat,) = libraries[unknown].call("observability", x, np.zeros((len(x), 0)), numbers(b))
        return flat.reshape(len(x), len(b.x), -1).transpose(0, 2, 1)

    return at_points


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
@pytest.mark.parametrize("unknown", HIGHEST_ORDER)
def test_1000_random_taut_points_are_all_full(unknown: str, matrices: Callable[[str, Array], Array]) -> None:
    x = points(unknown, 20_000, 1)
    x = (x if unknown == "u" else x[free(x)])[:1000]
    assert len(x) == 1000
    M = matrices(unknown, x)
    for order, rank in ((0, 3), (1, 6), (2, 7), *([(6, 7)] if unknown == "u" else [])):
        assert np.all(ranks_of(M[:, : 3 * (order + 1)], size_list(unknown), 3) == rank), order
    # smallest of the thousand: 8.8e-3 (u, orders 0–6) and 1.5e-3 (a, orders 0–2)
    verdicts = [judge(at_point, list(block(unknown).x), sizes(block(unknown)), 3) for at_point in M[:100]]
    assert all(v.full and v.singular_values[-1] > 1e-4 * v.singular_values[0] for v in verdicts)


@pytest.mark.numerics
def test_a_limited_force_factor_hides_its_activation(matrices: Callable[[str, Array], Array]) -> None:
    """At a limit of z the velocity does not depend on a: the taut set alone is not enough for the a form."""
    x = points("a", 2000, 2)
    x = x[~free(x)]
    z = force_factors(x)
    limited = (z <= 0) | (z >= 1.45)
    M = matrices("a", x)
    assert np.all(ranks_of(M, size_list("a"), 3) == 7 - limited.sum(axis=0))
    for at_point, hidden in list(zip(M, limited.T, strict=True))[:50]:
        lost = judge(at_point, list(block("a").x), sizes(block("a")), 3).unobservable
        assert lost == tuple(name for name, h in zip(("a1", "a2"), hidden, strict=True) if h)


@pytest.mark.numerics
@pytest.mark.parametrize("unknown", HIGHEST_ORDER)
@pytest.mark.parametrize("slack", [(0,), (1,), (0, 1)])
def test_random_slack_points_lose_two_each(
    unknown: str, slack: tuple[int, ...], matrices: Callable[[str, Array], Array]
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
    M = matrices(unknown, x)
    assert np.all(ranks_of(M, size_list(unknown), 3) == 7 - 2 * len(slack))
    lost = judge(M[0], list(block(unknown).x), sizes(block(unknown)), 3).unobservable
    assert set(lost) == {name for j in slack for name in (f"x{j + 3}", f"{unknown}{j + 1}")}


@pytest.mark.numerics
@pytest.mark.parametrize(("unknown", "order", "nearest"), [("u", 6, 1e-15), ("u", 2, 3e-9), ("a", 2, 3e-4)])
def test_how_near_the_edge_a_taut_tendon_is_seen(
    unknown: str, order: int, nearest: float, matrices: Callable[[str, Array], Array]
) -> None:
    """x₃ − 2 (and x₄ − 2) down to which the rank is 7; orders up to 2 fade as Φ′/Φ″, in the a form also as z."""
    for both in (False, True):
        x = points(unknown, 20_000, 4)
        x[:, 2] = 2 + nearest
        if both:
            x[:, 3] = 2 + nearest
        x = (x if unknown == "u" else x[free(x)])[:300]
        assert len(x) == 300
        assert np.all(ranks_of(matrices(unknown, x)[:, : 3 * (order + 1)], size_list(unknown), 3) == 7)
