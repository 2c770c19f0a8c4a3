"""The kernel's own exp, sin, cos: their last bits, the same in every build; and what fmin, fmax do with no number."""

import casadi as ca
import numpy as np
import pytest

from hillobs.codegen.shared_library import Library, compile_functions
from hillobs.codegen.toolchain import NATIVE, SINGLE
from hillobs.model.arrays import Array

pytestmark = pytest.mark.numerics

FUNCTIONS = {"exp": ca.exp, "sin": ca.sin, "cos": ca.cos}
# x87's 64 bits of fraction, or 113: an oracle that is right to a small part of a double's last bit
WIDE = np.finfo(np.longdouble).nmant >= 63
needs_width = pytest.mark.skipif(not WIDE, reason="long double is no wider than double here")
# vectors, one run at a time, and one at a time with the instructions of the vectors
BUILDS = [NATIVE, "scalar", SINGLE]
EDGES = [0.0, -0.0, 5e-324, -5e-324, 2.2250738585072014e-308, 1e-300, -1e-300, 1.0, -1.0, np.nextafter(1, 0)]
NOT_FINITE = [np.nan, np.inf, -np.inf]


@pytest.fixture(scope="module")
def builds() -> dict[str, Library]:
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    every = [ca.Function(f"kernel_{name}", [x], [f(x)]) for name, f in FUNCTIONS.items()]
    every += [ca.Function("kernel_fmin", [x, y], [ca.fmin(x, y)]), ca.Function("kernel_fmax", [x, y], [ca.fmax(x, y)])]
    every += [ca.Function("kernel_slope", [x], [ca.jacobian(ca.fabs(x), x)])]
    every += [ca.Function("kernel_root", [x], [ca.if_else(x > 0, ca.sqrt(x), 0, True)])]
    return {target: compile_functions(every, target) for target in BUILDS}


def value(library: Library, name: str, *arguments: Array) -> Array:
    (result,) = library.call(f"kernel_{name}", *(np.reshape(argument, (-1, 1)) for argument in arguments))
    return result[:, 0]


def ulps(found: Array, exact: np.ndarray, scale: np.ndarray | None = None) -> float:
    """The largest error in units of the last place of the exact value, or of `scale`."""
    unit = np.spacing(np.abs(exact if scale is None else scale).astype(float)).astype(np.longdouble)
    return float(np.max(np.abs(found.astype(np.longdouble) - exact) / unit))


def near(points: Array) -> Array:
    """Each number and its neighbours."""
    return np.concatenate([points, np.nextafter(points, np.inf), np.nextafter(points, -np.inf)])


def arguments_of_exp() -> Array:
    random = np.random.default_rng(1)
    halves = (np.arange(-2150, 2050) + 0.5) * np.log(2) / 2  # where the reduction changes its whole number, and between
    edges = [709.782712893384, -708.3964185322641, -745.1332191019411, -744.4400719213812]
    spread = random.uniform(-745, 709.7, 50_000), random.normal(0, 1, 40_000), random.normal(0, 1, 5000) * 1e-9
    return np.concatenate([*spread, near(halves), EDGES, near(np.array(edges[1:])), [edges[0]]]).clip(-746, edges[0])


def arguments_of_sine() -> Array:
    random = np.random.default_rng(2)
    turns = np.arange(-4000, 4001) * (np.pi / 2)
    spread = random.uniform(-10, 10, 30_000), random.uniform(-1e5, 1e5, 45_000)
    far = random.uniform(-1, 1, 5000) * 10.0 ** random.uniform(5, 300, 5000)
    edges = [1e5, -1e5, 1e22, 2.0**1000, np.finfo(float).max]
    return np.concatenate([*spread, near(turns), near(np.array(edges[:2])), far, edges, EDGES])


@needs_width
@pytest.mark.parametrize("build", BUILDS)
def test_exp_is_right_to_two_units_in_the_last_place(builds, build: str) -> None:
    x = arguments_of_exp()
    assert len(x) > 100_000
    exact = np.exp(x.astype(np.longdouble))
    assert (exact < np.finfo(float).tiny).any()  # subnormal results too
    assert ulps(value(builds[build], "exp", x), exact) <= 2


@needs_width
@pytest.mark.parametrize("build", BUILDS)
@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sin_and_cos_are_right_to_two_units_in_the_last_place(builds, name: str, build: str) -> None:
    """Of their value for |x| ≤ 10; of the larger of the two everywhere."""
    x = arguments_of_sine()
    wide = x.astype(np.longdouble)
    exact = {"sin": np.sin, "cos": np.cos}[name](wide)
    larger = np.maximum(np.abs(np.sin(wide)), np.abs(np.cos(wide)))
    found = value(builds[build], name, x)
    assert len(x) > 100_000
    assert ulps(found, exact, larger) <= 2
    close = (np.abs(x) <= 10) & (exact != 0)
    assert ulps(found[close], exact[close]) <= 2


@pytest.mark.parametrize("name", FUNCTIONS)
def test_one_lane_at_a_time_gives_the_bits_of_many(builds, name: str) -> None:
    """With the same instructions; without fused ones the last bit may be another."""
    x = np.concatenate([arguments_of_exp(), arguments_of_sine(), NOT_FINITE, [800.0, -800.0, 1e308, -1e308]])
    if name != "exp":
        x = x[~(np.abs(x) > 1e5)]  # beyond, it is the system's
    one, other = (value(builds[build], name, x) for build in (NATIVE, SINGLE))
    assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_value_depends_on_no_other_lane(builds, name: str) -> None:
    """Far angles, no numbers and ordinary ones side by side, in any order."""
    x = np.concatenate([arguments_of_sine()[::97], NOT_FINITE, [1e6, 1e300]])
    alone = np.concatenate([value(builds[NATIVE], name, x[i : i + 1]) for i in range(0, len(x), 7)])
    order = np.random.default_rng(3).permutation(len(x))
    mixed = np.empty_like(x)
    mixed[order] = value(builds[NATIVE], name, x[order])
    np.testing.assert_array_equal(mixed[::7].view(np.uint64), alone.view(np.uint64))


@pytest.mark.parametrize("build", BUILDS)
def test_what_is_not_finite(builds, build: str) -> None:
    np.testing.assert_array_equal(value(builds[build], "exp", [np.nan, np.inf, -np.inf]), [np.nan, np.inf, 0])
    np.testing.assert_array_equal(value(builds[build], "exp", [710.0, 1e308, -746.0, -1e308]), [np.inf, np.inf, 0, 0])
    for name in ("sin", "cos"):
        assert np.isnan(value(builds[build], name, NOT_FINITE)).all()
    np.testing.assert_array_equal(value(builds[build], "sin", [0.0, -0.0, 5e-324]), [0, 0, 5e-324])
    np.testing.assert_array_equal(value(builds[build], "exp", [0.0, -0.0, 5e-324]), [1, 1, 1])
    np.testing.assert_array_equal(value(builds[build], "cos", [0.0, -0.0, 5e-324]), [1, 1, 1])


@pytest.mark.parametrize("build", BUILDS)
@pytest.mark.parametrize("name", ["fmin", "fmax"])
def test_of_two_numbers_the_first_stays_visible_if_it_is_none(builds, build: str, name: str) -> None:
    """So that a clamp of no number is no number; where the second is none, the first is the result."""
    some = np.array([0.0, -0.0, 1.5, -1e308, 5e-324, np.inf, -np.inf])
    none = np.full(len(some), np.nan)
    assert np.isnan(value(builds[build], name, none, some)).all()
    np.testing.assert_array_equal(value(builds[build], name, some, none), some)
    a, b = (pairs.ravel() for pairs in np.meshgrid(some, some))
    np.testing.assert_array_equal(
        value(builds[build], name, a, b), {"fmin": np.minimum, "fmax": np.maximum}[name](a, b)
    )


@pytest.mark.parametrize("build", BUILDS)
def test_a_function_with_a_branch_has_one_in_no_lane(builds, build: str) -> None:
    x = np.array([-2.0, -0.0, 0.0, 4.0, 1e300, -5e-324, np.inf])
    np.testing.assert_array_equal(value(builds[build], "slope", x), np.sign(x))
    np.testing.assert_array_equal(value(builds[build], "root", x[:-1]), np.sqrt(np.maximum(x[:-1], 0)))
