"""The quick inverse of the tendon: where it does not doubt itself, it is right to the last bits."""

import casadi as ca
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.codegen.shared_library import Library, compile_functions
from hillobs.model.block import symbols
from hillobs.model.curves import NGUYEN2019
from hillobs.model.curves.nguyen2019 import TENDON

pytestmark = pytest.mark.numerics

# forces at the four stages of a step
STAGES = 4
needs_width = pytest.mark.skipif(np.finfo(np.longdouble).nmant < 63, reason="long double is no wider than double here")
# of L; what the slow inverse holds too
RIGHT = 1e-15
PAPER = [TENDON[name].default for name in TENDON]


@pytest.fixture(scope="module")
def library() -> Library:
    p = symbols(TENDON)
    ys = [ca.SX.sym(f"y{i}") for i in range(STAGES)]
    values, doubt = NGUYEN2019.Phi_S_inv_near(ys, p)
    numbers = [ca.vertcat(*ys), p.vector()]
    slow = ca.vertcat(*(NGUYEN2019.Phi_S_inv(y, p) for y in ys))
    return compile_functions(
        [
            ca.Function("near", numbers, [ca.vertcat(*values), ca.densify(doubt)]),
            ca.Function("slow", numbers, [slow]),
        ]
    )


@st.composite
def tendons(draw: st.DrawFn) -> list[float]:
    """Numbers of a tendon that rises: k toe < 2.5 F_toe."""
    L_slack, toe, F_toe = draw(st.floats(0.1, 10)), draw(st.floats(1e-3, 0.5)), draw(st.floats(1e-2, 5))
    k = draw(st.floats(0.02, 0.98)) * 2.5 * F_toe / toe
    values = dict(zip(TENDON, (L_slack, toe, F_toe, k), strict=True))
    assert not NGUYEN2019.objection(values)
    return list(values.values())


def steps(seed: int, tendon: list[float], points: int) -> np.ndarray:
    """(points × stages) forces of a step: anywhere on the curve, and then close together."""
    random, F_toe = np.random.default_rng(seed), tendon[2]
    first = F_toe * random.choice([random.uniform(0, 1.5, points), 10.0 ** random.uniform(-12, 0, points)])
    width = 10.0 ** random.uniform(-12, -1, (points, 1))
    return first[:, None] + F_toe * width * np.hstack([np.zeros((points, 1)), random.uniform(-1, 1, (points, 3))])


def exact(forces: np.ndarray, tendon: list[float], start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Φ_S⁻¹ by Newton's method in long double, and what rounding the quintic in double makes of it, as a length."""
    L_slack, toe, F, k = (np.longdouble(value) for value in tendon)
    D = toe * k
    A3, A4, A5 = 10 * F - 4 * D, -15 * F + 7 * D, 6 * F - 3 * D
    y = forces.astype(np.longdouble)
    force, beyond = np.clip(y, 0, F), np.maximum(y - F, 0) / k
    s = np.clip((start - L_slack - beyond) / toe, 1e-9, 1)
    for _ in range(6):
        s = s - (s**3 * (A3 + s * (A4 + s * A5)) - force) / (s**2 * (3 * A3 + s * (4 * A4 + s * 5 * A5)))
    size = s**3 * (np.abs(A3) + s * (np.abs(A4) + s * np.abs(A5)))
    slope = s**2 * (3 * A3 + s * (4 * A4 + s * 5 * A5))
    return L_slack + toe * s + beyond, np.finfo(float).eps * toe * size / slope


@needs_width
@given(tendon=tendons(), seed=st.integers(0, 2**32))
def test_where_it_does_not_doubt_it_is_right(library: Library, tendon: list[float], seed: int) -> None:
    """To 1e−15 of the length, and what the rounding of a quintic that is nearly flat adds."""
    forces = steps(seed, tendon, 500)
    near, doubt = library.call("near", forces, tendon)
    assert np.isin(doubt, [0, 1]).all()
    sure = doubt[:, 0] == 0
    truth, rounding = exact(forces[sure], tendon, near[sure])
    assert (np.abs(near[sure] - truth) <= RIGHT * truth + rounding).all()


@given(first=st.floats(0.06, 0.49), width=st.floats(0, 1e-5))
def test_it_does_not_doubt_the_forces_of_a_run(library: Library, first: float, width: float) -> None:
    """Of the paper's tendon, in a step of 5e−4; there it is the slow inverse to the last bits."""
    forces = first + width * np.array([[0.0, 0.5, 0.5, 1.0]])
    near, doubt = library.call("near", forces, PAPER)
    assert doubt == 0
    np.testing.assert_allclose(near, library.call("slow", forces, PAPER)[0], rtol=RIGHT)


def test_its_values_are_those_of_forty_digits(library: Library) -> None:
    y = np.linspace(0.06, 0.6, 40)
    near, doubt = library.call("near", np.tile(y[:, None], STAGES), PAPER)
    assert (doubt == 0).all()
    with mpmath.workdps(40):
        L_slack, toe, F, k = map(mpmath.mpf, PAPER)
        A3, A4, A5 = 10 * F - 4 * toe * k, -15 * F + 7 * toe * k, 6 * F - 3 * toe * k
        for force, length in zip(y, near[:, -1], strict=True):
            quintic = [A5, A4, A3, 0, 0, -min(mpmath.mpf(force), F)]
            (s,) = [
                root for root in mpmath.polyroots(quintic, 200, extraprec=200) if root.imag == 0 and 0 < root <= 1.0001
            ]
            truth = L_slack + toe * s + max(mpmath.mpf(force) - F, 0) / k
            assert abs(mpmath.mpf(length) - truth) <= RIGHT * truth


@pytest.mark.parametrize("stage", range(STAGES))
@pytest.mark.parametrize("odd", [np.nan, -np.inf, 1e-3, -1.0, 0.0])
def test_it_doubts_what_is_no_number_or_far_from_the_first(library: Library, stage: int, odd: float) -> None:
    forces = np.full((1, STAGES), 0.25)
    assert library.call("near", forces, PAPER)[1] == 0
    forces[0, stage] = odd
    near, doubt = library.call("near", forces, PAPER)
    # no number is a result of its own: then nobody has to doubt it
    assert doubt == 1 or np.isnan(near[0, stage])


@pytest.mark.parametrize("number", range(len(PAPER)))
def test_it_doubts_a_tendon_without_numbers(library: Library, number: int) -> None:
    """Its length, which only shifts the result, makes that no number itself."""
    tendon = [np.nan if i == number else value for i, value in enumerate(PAPER)]
    near, doubt = library.call("near", np.full((1, STAGES), 0.25), tendon)
    assert doubt == 1 or np.isnan(near).all()
