"""Laws that hold for every curve set."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curve_values import CURVE_NAMES, NORMALISED, OTHER, RANGES, SETS, at, numbers
from hillobs.model.curves import SIMULATED
from hillobs.model.curves.bezier import Knot, through

every_set = pytest.mark.parametrize("name", SETS)
own_units = st.sampled_from([{}, OTHER])


@every_set
@settings(max_examples=40)
@given(forces=st.lists(st.floats(1e-9, 3.0), min_size=1, max_size=30), units=own_units)
def test_a_tendon_has_the_force_that_its_length_was_asked_for(
    name: str, forces: list[float], units: dict[str, float]
) -> None:
    lengths = at(name, "Phi_S_inv", forces, **units)
    np.testing.assert_allclose(at(name, "Phi_S", lengths, **units), forces, rtol=1e-12, atol=1e-13)


@every_set
@settings(max_examples=40)
@given(
    a=st.floats(0.01, 1.0),
    L_C=st.floats(0.6, 1.6),
    share=st.floats(0.02, 0.98),
    units=own_units,
)
def test_the_activation_is_the_one_that_gave_the_velocity(
    name: str, a: float, L_C: float, share: float, units: dict[str, float]
) -> None:
    """For any force between that of the fastest fibre and that of the limit z_max, damping included."""
    F = at(name, "Phi_P", L_C, **units) + share * 1.35 * a * at(name, "f", L_C, **units)
    u = at(name, "velocity", F, L_C, a, **units)
    assert at(name, "velocity", F, L_C, a, order=1, **units)[0] == 0
    assert at(name, "activation", F, L_C, u, **units)[0] == pytest.approx(a, rel=1e-9)


@every_set
@settings(max_examples=30)
@given(z=st.floats(0.0, 1.39), units=own_units)
def test_g_inverts_its_inverse(name: str, z: float, units: dict[str, float]) -> None:
    units = {**units, "damping": 0.0}
    assert at(name, "g", at(name, "g_inv", z, **units), **units)[0] == pytest.approx(z, abs=1e-12)


@every_set
@pytest.mark.parametrize("units", [{}, OTHER])
def test_curves_rise_and_fall_as_they_must(name: str, units: dict[str, float]) -> None:
    slack = numbers(name, **units)["L_slack"]
    lengths, fibres = np.linspace(0.8 * slack, 1.2 * slack, 3001), np.linspace(0.3, 2.2, 3001)
    assert (np.diff(at(name, "Phi_S", lengths, **units)) >= -1e-14).all()
    assert (np.diff(at(name, "Phi_S_inv", np.linspace(0, 3, 3001), **units)) > 0).all()
    assert (np.diff(at(name, "Phi_P", fibres, **units)) >= -1e-14).all()
    fastest = 1.2 * 0.8 if units else 1.0  # l_opt·v_max; Millard's damped fibre has no slope beyond
    assert (np.diff(at(name, "g", np.linspace(-0.98, 0.98, 3001) * fastest, **units)) < 0).all()
    assert (np.diff(at(name, "g", np.linspace(-4, 0.95, 3001), **units)) <= 1e-14).all()
    assert (np.diff(at(name, "g_inv", np.linspace(0, 1.39, 3001), **{**units, "damping": 0.0})) < 0).all()
    velocities = at(name, "velocity", np.linspace(0.1, 3, 3001), 1.1, 0.4, **units)
    assert (np.diff(velocities) <= 1e-14).all()


# where curves are joined, in lengths and velocities of a muscle whose units are the pair's, and how smooth they are
JOINTS = [
    ("nguyen2019", "Phi_S", (2.0, 2.04), 2),
    ("nguyen2019", "Phi_P", (1.0,), 2),
    ("nguyen2019", "g", (0.0,), 1),
    ("thelen2003", "Phi_S", (2 * (1 + 0.04 * 99 * np.exp(3) / (166 * np.exp(3) - 67)),), 1),
    ("thelen2003", "g", (0.0,), 0),
    ("thelen2003", "g", (1.0, -0.33 * 0.4 / (10 * 0.07)), 1),
    ("millard2012", "Phi_S", (2.0,), 2),
    ("millard2012", "Phi_P", (1.0, 1.035, 1.7), 2),
    ("millard2012", "f", (0.4441, 0.58705, 0.84, 1.0, 1.43115, 1.8123), 2),
    ("millard2012", "g", (-1.0, -0.9, 0.0, 0.9, 1.0), 2),
    ("degroote_fregly2016", "Phi_S", (2.0,), 2),
]


@pytest.mark.parametrize(("name", "curve", "joints", "order"), JOINTS)
def test_derivatives_agree_on_both_sides_of_a_joint(
    name: str, curve: str, joints: tuple[float, ...], order: int
) -> None:
    h = 1e-9
    spread = np.linspace(0.3, 2.2, 401) if curve in ("Phi_P", "f") else np.linspace(-1.2, 1.1, 401)
    spread = np.linspace(1.9, 2.1, 401) if curve == "Phi_S" else spread
    for derivative in range(order + 1):
        scale = np.abs(at(name, curve, spread, order=derivative)).max()
        for joint in joints:
            left, right = at(name, curve, [joint - h, joint + h], order=derivative)
            assert abs(left - right) <= 2e-5 * scale, (joint, derivative)
    if name == "thelen2003" and order < 2:
        # and no smoother, so that the table of docs/curves.md is right
        left, right = at(name, curve, [joints[-1] - h, joints[-1] + h], order=order + 1)
        assert abs(left - right) > 1e-2


@every_set
@pytest.mark.parametrize("curve", CURVE_NAMES)
def test_derivatives_are_those_of_finite_differences(name: str, curve: str) -> None:
    x, h = np.random.default_rng(1).uniform(*RANGES[curve], 300), 1e-6
    difference = (at(name, curve, x + h) - at(name, curve, x - h)) / (2 * h)
    np.testing.assert_allclose(at(name, curve, x, order=1), difference, rtol=2e-5, atol=2e-4)


@every_set
@pytest.mark.parametrize("units", [{}, OTHER])
def test_no_curve_is_ever_not_a_number(name: str, units: dict[str, float]) -> None:
    """Far out it may be infinite: where an exponential is, or at a pole."""
    far = [sign * value for sign in (1, -1) for value in (0.0, 1e-300, 1e-45, 1e-9, 0.5, 1.0, 2.0, 9.0, 1e3, 1e6)]
    knots = [joint for _, _, joints, _ in JOINTS for joint in joints]
    for curve in ("Phi_S", "Phi_S_inv", "Phi_P", "f", "g"):
        values = at(name, curve, [*far, *knots], **units)
        assert not np.isnan(values).any(), curve
        assert np.isfinite(values[np.abs([*far, *knots]) < 5]).all(), curve
        near = [x for x in (*far, *knots) if abs(x) < 5]
        assert np.isfinite(at(name, curve, near, order=1, **units)).all(), curve
    for force in (0.0, 1e-9, 1.0, 50.0, -5.0):
        velocities = at(name, "velocity", force, 0.9, [0.01, 1.0], **units)
        assert np.isfinite(velocities).all()
        for u in (-5.0, 0.0, 0.25, 0.95):
            assert np.isfinite(at(name, "activation", force, [0.1, 1.0, 3.0], u, **units)).all()
    infinite = at(name, "Phi_S_inv", [-np.inf, np.inf], **units)
    assert np.isfinite(infinite[0])
    assert infinite[1] == np.inf


@every_set
def test_a_force_too_low_gives_the_shortest_length(name: str) -> None:
    low, lower = at(name, "Phi_S_inv", [-1.0, -50.0])
    assert low == lower
    if name == "degroote_fregly2016":  # this tendon pushes, but never with 0.2
        assert low < 2.0
        assert at(name, "Phi_S_inv", -0.19)[0] > low
        assert at(name, "Phi_S", 1.0)[0] > -0.2
    else:
        assert low == pytest.approx(2.0, abs=1e-14)
        assert at(name, "Phi_S", 1.9)[0] == 0.0


def test_passive_force_is_there_below_the_optimal_length_where_the_publication_says_so() -> None:
    passive = {name: at(name, "Phi_P", 0.9)[0] for name in SIMULATED}
    assert passive.pop("degroote_fregly2016") > 0.005
    assert set(passive.values()) == {0.0}


def test_a_tendon_has_its_strain_at_F_max() -> None:
    for name in NORMALISED:
        stretched = at(name, "Phi_S", 1.7 * 1.05, **{**OTHER, "tendon_strain": 0.05})
        assert stretched[0] == pytest.approx(0.7, rel=1e-12), name
        passive = at(name, "Phi_P", 1.2 * 1.65, **{**OTHER, "passive_strain": 0.65})
        assert passive[0] == pytest.approx(0.7, rel=1e-12), name


@settings(max_examples=25)
@given(
    slopes=st.tuples(st.floats(0.1, 0.4), st.floats(0.6, 0.95), st.floats(1.3, 4.0)),
    curviness=st.floats(0.0, 1.0),
    x=st.floats(-1.0, 4.0),
)
def test_a_bezier_curve_rises_and_its_inverse_finds_back(
    slopes: tuple[float, float, float], curviness: float, x: float
) -> None:
    knots = [Knot(0.0, 0.0, slopes[0]), Knot(1.0, 0.5, slopes[1]), Knot(2.0, 1.6, slopes[2])]
    curve, s = through(knots, [curviness] * 2), ca.SX.sym("s")
    f = ca.Function("f", [s], [curve(s), curve.inverse(curve(s)), ca.jacobian(curve(s), s)])
    _, back, slope = (float(v) for v in f(x))
    assert back == pytest.approx(x, abs=1e-9)
    assert slope > 0
