"""What a muscle's numbers leave unexplained: nothing of a muscle that has them; and the derivatives of it."""

import casadi as ca
import numpy as np
import pytest

from hillobs.model.arrays import Array
from hillobs.model.curves import CURVES, NGUYEN2019_PRINTED, CurveSet
from hillobs.model.curves.sizes import relative
from hillobs.model.muscle import virtual_muscle
from hillobs.observers.behind.balance import KNOWN, balance, tendon_force
from hillobs.observers.behind.sensitivity import PENNATION, muscle_numbers

pytestmark = pytest.mark.numerics

# in SI, and a fibre with some damping
SIZES = {"F_max": 800.0, "l_opt": 0.08, "L_slack": 0.2, "v_max": 8.0}
OTHERS = {PENNATION: 0.3, "damping": 0.05}
# the printed toe jumps; only a set with sizes has oblique fibres
CASES = [
    pytest.param(curves, oblique, id=f"{curves.name}{'-oblique' * oblique}")
    for curves in CURVES.values()
    for oblique in (False, True)
    if curves is not NGUYEN2019_PRINTED and ("l_opt" in curves.parameters or not oblique)
]
# the square of a relative step, times a third derivative over a strain of 0.03, and what rounding leaves
STEP, TOLERANCE = 1e-6, 1e-6


def numbers_of(curves: CurveSet, oblique: bool) -> dict[str, float]:
    defaults = {name: parameter.default for name, parameter in curves.parameters.items()}
    return {name: {**defaults, **SIZES, **OTHERS}[name] for name in muscle_numbers(curves, oblique)}


def at_work(curves: CurveSet, oblique: bool) -> Array:
    """KNOWN (n × 5) in SI of muscles with these numbers, long and short, fast and slow, by the model of the truth."""
    block, theta = virtual_muscle(curves, oblique), numbers_of(curves, oblique)
    own = {**theta, **relative(theta, theta)}
    p = [own.get(name, parameter.default) for name, parameter in block.parameters.items()]
    told = ca.vertcat(block.y.Phi_S, ca.jacobian(block.y.Phi_S, block.x.L_S), block.dx.L_S, block.y.a)
    f = ca.Function("told", [block.x.vector(), block.u.vector(), block.p.vector()], [told])
    rows = []
    for stretch, fibre, dL_m, u in ((1.02, 0.9, 0.1, 0.2), (1.03, 1.1, -0.2, -0.1), (1.01, 1.15, 0.1, 0.0)):
        L_S = own["L_slack"] * stretch
        Phi_S, slope, dL_S, a = np.array(f(L_S, [L_S + fibre, dL_m, u], p), dtype=float).ravel()
        # τ = v_max t,  lengths in l_opt
        rate, length = theta["v_max"], theta["l_opt"]
        F, dF = theta["F_max"] * np.array([Phi_S, slope * dL_S * rate])
        rows.append([F, dF, (L_S + fibre) * length, dL_m * length * rate, a])
    return np.array(rows)


@pytest.mark.parametrize(("curves", "oblique"), CASES)
def test_a_muscle_with_its_own_numbers_leaves_nothing(curves: CurveSet, oblique: bool) -> None:
    """To what inverting tendon and force-velocity curve leaves."""
    e, theta = balance(curves, oblique), list(numbers_of(curves, oblique).values())
    for known in at_work(curves, oblique):
        assert abs(float(e(known, theta)[0])) < 1e-8 * SIZES["F_max"]


@pytest.mark.parametrize(("curves", "oblique"), CASES)
def test_its_derivatives_are_those_of_differences(curves: CurveSet, oblique: bool) -> None:
    """Against a number's own share, ∂e/∂x x, in F_max."""
    function, theta = balance(curves, oblique), np.array(list(numbers_of(curves, oblique).values()))
    for known in at_work(curves, oblique):
        told = np.array(function(known, theta), dtype=float).ravel()[1:]
        x = np.concatenate([known, theta])
        for i, value in enumerate(x):
            step = STEP * value * (np.arange(len(x)) == i)
            above, below = (function(*np.split(x + sign * step, [len(KNOWN)]))[0] for sign in (1, -1))
            difference = float(above - below) / (2 * STEP)
            assert abs(difference - told[i] * value) < TOLERANCE * max(SIZES["F_max"], abs(difference)), i


@pytest.mark.parametrize(("curves", "oblique"), CASES)
def test_the_force_is_in_the_units_of_the_numbers(curves: CurveSet, oblique: bool) -> None:
    """In mm and kN it is the same force, and the same muscle."""
    names = muscle_numbers(curves, oblique)
    theta = np.array(list(numbers_of(curves, oblique).values()))
    other = theta * [{"F_max": 1e-3, "l_opt": 1e3, "L_slack": 1e3}.get(name, 1.0) for name in names]
    e, force, L_S = balance(curves, oblique), tendon_force(curves, oblique), 1.02 * SIZES["L_slack"]
    for known in at_work(curves, oblique):
        there = known * [1e-3, 1e-3, 1e3, 1e3, 1]
        here = float(e(known * [1.1, 1, 1, 1, 1], theta)[0])
        assert float(e(there * [1.1, 1, 1, 1, 1], other)[0]) == pytest.approx(1e-3 * here)
    F, slope = force(L_S, theta).full().ravel()
    assert force(1e3 * L_S, other).full().ravel() == pytest.approx([1e-3 * F, 1e-6 * slope])
