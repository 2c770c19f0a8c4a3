"""Laws of the muscle's curves: inverse pairs, joints, monotony, derivatives."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hillobs.model.block import symbols
from hillobs.model.curves import NGUYEN2019, NGUYEN2019_PRINTED, CurveSet
from independent import muscle

NUMBERS = {name: parameter.default for name, parameter in NGUYEN2019.parameters.items()}


def compiled(name: str, curves: CurveSet = NGUYEN2019) -> ca.Function:
    argument, p = ca.SX.sym("x"), symbols(curves.parameters)
    value = getattr(curves, name)(argument, p)
    return ca.Function(name, [argument, p.vector()], [value, ca.jacobian(value, argument)])


CURVE = {name: compiled(name) for name in ("Phi_S", "Phi_S_inv", "Phi_P", "f", "g", "g_inv")}


def value(name: str, argument: float, **numbers: float) -> float:
    return float(CURVE[name](argument, list({**NUMBERS, **numbers}.values()))[0])


def slope(name: str, argument: float) -> float:
    return float(CURVE[name](argument, list(NUMBERS.values()))[1])


tendons = st.fixed_dictionaries(
    {
        "L_slack": st.floats(0.5, 5.0),
        "toe": st.floats(0.01, 0.1),
        "F_toe": st.floats(0.1, 2.0),
        # k·toe/F_toe from a quarter of the end-to-end slope to just below the limit 2.5
        "k": st.floats(0.25, 2.45),
    }
).map(lambda n: {**n, "k": n["k"] * n["F_toe"] / n["toe"]})


@given(st.floats(1e-9, 3.0))
def test_Phi_S_inverts_its_inverse(y: float) -> None:
    # a tendon length near 2 resolves forces to 19.2 eps(2) only
    assert value("Phi_S", value("Phi_S_inv", y)) == pytest.approx(y, rel=1e-12, abs=2e-14)


@given(st.floats(2.0005, 2.5))
def test_inverse_of_Phi_S_returns_the_length(L: float) -> None:
    assert value("Phi_S_inv", value("Phi_S", L)) == pytest.approx(L, abs=1e-12)


@given(tendons, st.floats(1e-6, 4.0))
def test_the_inverse_holds_for_every_valid_tendon(tendon: dict[str, float], share: float) -> None:
    y = share * tendon["F_toe"]
    L = value("Phi_S_inv", y, **tendon)
    assert value("Phi_S", L, **tendon) == pytest.approx(y, rel=1e-9, abs=1e-11)
    assert NGUYEN2019.objection({**NUMBERS, **tendon}) == ""


@given(st.floats(-10.0, 0.0))
def test_a_slack_tendon_is_at_its_edge(y: float) -> None:
    assert value("Phi_S_inv", y) == 2.0


@given(st.floats(-5.0, 0.999))
def test_g_inverts_its_inverse_for_velocities(u: float) -> None:
    assert value("g_inv", value("g", u)) == pytest.approx(u, abs=1e-12, rel=1e-12)


@given(st.floats(0.0, 1.49))
def test_g_inverts_its_inverse_for_force_factors(z: float) -> None:
    assert value("g", value("g_inv", z)) == pytest.approx(z, abs=1e-12)


@given(tendons, st.floats(-1.0, 3.0), st.floats(1e-6, 1.0))
def test_Phi_S_rises(tendon: dict[str, float], place: float, step: float) -> None:
    L = tendon["L_slack"] + place * tendon["toe"]
    assert value("Phi_S", L + step, **tendon) >= value("Phi_S", L, **tendon) - 1e-14


@given(st.floats(-2.0, 1.4), st.floats(1e-3, 1.0))
def test_g_inv_falls_on_its_domain(z: float, step: float) -> None:
    low = max(z, -0.24)
    high = min(low + step, 1.49)
    assert value("g_inv", high) < value("g_inv", low) or high == low


@pytest.mark.parametrize("joint", [2.0, 2.04])
def test_Phi_S_is_twice_continuously_differentiable_at_its_joints(joint: float) -> None:
    """Second differences on both sides agree; the third derivative jumps (C² only)."""
    h = 1e-6
    for derivative in (0, 1):
        left, right = (CURVE["Phi_S"](joint + s * h, list(NUMBERS.values()))[derivative] for s in (-1, 1))
        assert float(left) == pytest.approx(float(right), abs=5e-4 if derivative else 5e-5)
    curvature = [(slope("Phi_S", joint + s * 2 * h) - slope("Phi_S", joint + s * h)) / h for s in (-1, 1)]
    assert abs(curvature[0] + curvature[1]) < 2.0  # against 1,500 at the middle of the toe


def test_the_values_at_the_joints_are_the_papers() -> None:
    assert value("Phi_S", 2.0) == 0.0
    assert value("Phi_S", 2.04) == pytest.approx(0.5, abs=1e-15)
    assert slope("Phi_S", 2.04) == pytest.approx(19.2308, rel=1e-13)
    assert slope("Phi_S", 2.0) == 0.0
    assert value("g_inv", 1.0) == 0.0
    assert slope("g_inv", 1.0) == pytest.approx(-0.25 / 1.25)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("Phi_S", 1.9, 2.2),
        ("Phi_S_inv", 0.01, 1.0),
        ("Phi_P", 0.5, 2.0),
        ("f", 0.0, 2.0),
        ("g", -3.0, 0.9),
        ("g_inv", 0.1, 1.4),
    ],
)
def test_derivatives_are_those_of_finite_differences(name: str, low: float, high: float) -> None:
    for x in np.random.default_rng(1).uniform(low, high, 200):
        h = 1e-6
        difference = (value(name, x + h) - value(name, x - h)) / (2 * h)
        assert slope(name, x) == pytest.approx(difference, rel=2e-5, abs=2e-4)


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=-1e6, max_value=1e6))
def test_no_curve_is_ever_not_a_number(x: float) -> None:
    for name in ("Phi_S", "Phi_S_inv", "Phi_P", "f", "g"):
        assert np.isfinite(value(name, x)), name
        assert np.isfinite(slope(name, x)) or (name, x) == ("g", -1e6), name


@settings(max_examples=200)
@given(st.floats(1.9, 2.3), st.floats(-0.1, 2.0), st.floats(0.2, 1.6), st.floats(-2.0, 0.99), st.floats(0.0, 1.49))
def test_they_are_those_of_the_independent_text(L: float, y: float, L_C: float, u: float, z: float) -> None:
    pairs = [("Phi_S", L), ("Phi_S_inv", y), ("Phi_P", L_C), ("f", L_C), ("g", u), ("g_inv", z)]
    for name, argument in pairs:
        expected = float(np.asarray(getattr(muscle, name)(np.array([[argument]])))[0, 0])
        assert value(name, argument) == pytest.approx(expected, rel=1e-12, abs=1e-12), name


def test_a_tendon_that_does_not_rise_is_objected_to() -> None:
    assert "must be below 2.5 F_toe" in NGUYEN2019.objection({**NUMBERS, "k": 31.3})


def test_the_printed_toe_jumps() -> None:
    """The rounded decimals of [PhiSj]: 0.06 at 2 and 0.565 at 2.04, to the noise of Horner's rule."""
    printed = compiled("Phi_S", NGUYEN2019_PRINTED)
    at = [float(printed(L, list(NUMBERS.values()))[0]) for L in (2.0, np.nextafter(2.04, 0), 2.04)]
    assert at == pytest.approx([0.06, 0.565395, 0.5], abs=2e-6)
