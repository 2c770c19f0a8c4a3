"""The plant and its controller: symmetry, drives, Lyapunov function, Riccati equation."""

import functools

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_are

from hillobs.model.block import Block, Symbols, symbols
from hillobs.model.control.backstepping import backstepping, riccati
from hillobs.model.curves import NGUYEN2019
from hillobs.model.loops.closed_loop import closed_loop
from hillobs.model.plant import DRIVES
from hillobs.model.plant import plant as plant_of
from hillobs.model.signals.reference import reference
from hillobs.model.signals.uncertainty import uncertainty
from hillobs.model.symbols import SIGNALS, STATES
from hillobs.model.system import PAIR


def numbers(block: Block, **changes: float) -> list[float]:
    return [changes.get(name, parameter.default) for name, parameter in block.parameters.items()]


plant_of = functools.cache(plant_of)


@functools.cache
def function(block: Block, *groups: str) -> ca.Function:
    entries = ca.vertcat(*(getattr(block, group).vector() for group in groups))
    return ca.Function("f", [block.x.vector(), block.u.vector(), block.p.vector()], [entries])


lengths = st.floats(1.99, 2.1)


@pytest.mark.parametrize("drive", DRIVES)
@given(
    x1=st.floats(2.4, 3.1),
    x2=st.floats(-0.3, 0.3),
    x3=lengths,
    x4=lengths,
    a=st.floats(0.05, 0.9),
    b=st.floats(0.05, 0.9),
)
def test_the_pair_is_its_own_mirror_image(
    drive: str, x1: float, x2: float, x3: float, x4: float, a: float, b: float
) -> None:
    """x₁ → C − x₁, x₂ → −x₂, muscles and inputs exchanged, Δ → −Δ: the same motion seen from the other side."""
    plant = plant_of(PAIR, drive)
    f, p, Delta, C = function(plant, "dx"), numbers(plant), 0.01, 5.54
    inputs = {"Delta": Delta, "u1": a - 0.5, "u2": b - 0.5, "a1": a, "a2": b}
    mirrored = {"Delta": -Delta, "u1": b - 0.5, "u2": a - 0.5, "a1": b, "a2": a}
    here = np.array(f([x1, x2, x3, x4], [inputs[name] for name in plant.u], p)).ravel()
    there = np.array(f([C - x1, -x2, x4, x3], [mirrored[name] for name in plant.u], p)).ravel()
    assert list(plant.x) == list(STATES)
    np.testing.assert_allclose(there, [-here[0], -here[1], here[3], here[2]], rtol=1e-9, atol=1e-9)


@given(st.floats(2.5, 2.9), st.floats(2.01, 2.03), st.floats(2.01, 2.03), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_requested_and_virtual_drive_agree_while_no_limit_is_active(
    x1: float, x3: float, x4: float, u1: float, u2: float
) -> None:
    blocks = {drive: plant_of(PAIR, drive) for drive in ("virtual", "requested")}
    x, u = [x1, 0.1, x3, x4], [0.0, u1, u2]
    rates = {drive: np.array(function(b, "dx")(x, u, numbers(b))).ravel() for drive, b in blocks.items()}
    requested = blocks["requested"]
    limits = np.array(function(requested, "guards")(x, u, numbers(requested))).ravel()
    if not limits.any():
        np.testing.assert_allclose(rates["requested"], rates["virtual"], atol=1e-12)


def test_an_activation_that_cannot_be_is_limited_and_reported() -> None:
    plant = plant_of(PAIR, "requested")
    outputs = dict(zip([*plant.y, *plant.guards], np.array(function(plant, "y", "guards")(
        [2.6, 0, 2.03, 2.03], [0, 0, 0], numbers(plant))).ravel().tolist(), strict=True))  # fmt: skip
    assert outputs["a1"] == 1.0
    assert outputs["a1_limit"] == 1.0
    assert outputs["u1"] < 0  # it cannot hold the tension and lengthens


@functools.cache
def gains() -> ca.Function:
    p = symbols("m q R")
    return ca.Function("riccati", [p.vector()], list(riccati(p)))


@given(st.floats(0.2, 5.0), st.floats(1.0, 50.0), st.floats(1.0, 100.0))
def test_K_and_P_solve_the_riccati_equation(m: float, q: float, R: float) -> None:
    K, P = gains()([m, q, R])
    A, B = np.array([[0, 1], [0, 0]]), np.array([[0], [1 / m]])
    expected = solve_continuous_are(A, B, q * np.eye(2), [[R]])
    np.testing.assert_allclose(P, expected, rtol=1e-8)
    np.testing.assert_allclose(K, B.T @ expected / R, rtol=1e-8)


def test_K_and_P_are_the_printed_ones() -> None:
    K, P = gains()([1, 10, 30])
    np.testing.assert_allclose(K, [[0.57735027, 1.21984994]], atol=5e-9)
    np.testing.assert_allclose(P, [[21.12842071, 17.32050808], [17.32050808, 36.59549815]], atol=5e-9)


def lyapunov() -> ca.Function:
    """V and V̇ along the closed loop of plant and controller, as a function of (x, t)."""
    controller, plant = backstepping(), plant_of()
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 4)
    states = dict(zip(STATES, ca.vertsplit(x), strict=True))

    def outputs(block: Block, inputs: dict[str, ca.SX]) -> Symbols:
        old = [*block.x.values(), *block.u.values(), *block.p.values()]
        new = [*(states[n] for n in block.x), *(inputs[n] for n in block.u), *map(ca.SX, numbers(block))]
        groups = {**block.y, **{f"d{n}": e for n, e in block.dx.items()}}
        return Symbols(zip(groups, ca.substitute(list(groups.values()), old, new), strict=True))

    signals = {"t": t, **states}
    r, Delta = outputs(reference(), signals), outputs(uncertainty(), signals)
    c = outputs(controller, {**states, **r, **Delta})
    dx = outputs(plant, {"Delta": Delta.Delta, "u1": c.u1, "u2": c.u2})
    rates = ca.vertcat(*(dx[f"d{name}"] for name in STATES))
    K, P = riccati(Symbols({name: ca.SX(controller.parameters[name].default) for name in ("m", "q", "R")}))
    e = ca.vertcat(x[0] - r.r, x[1] - r.dr)
    w = c.zeta + K @ e
    # V = ½ eᵀP e + ½ w²
    V = (e.T @ P @ e + w**2) / 2
    return ca.Function("V", [x, t], [V, ca.jtimes(V, x, rates) + ca.jacobian(V, t), w, e])


def test_the_lyapunov_function_decreases_along_the_corrected_controller() -> None:
    """V̇ = −½ eᵀ(Q + KᵀRK) e − γ w², to rounding, wherever a tendon is taut and u is not limited."""
    V = lyapunov()
    random = np.random.default_rng(0)
    K = np.array([[0.57735027, 1.21984994]])
    Q = 10 * np.eye(2) + 30 * K.T @ K
    for _ in range(500):
        x = [2.63 + random.normal() * 0.02, random.normal() * 0.02, *random.uniform(2.012, 2.05, 2)]
        _, rate, w, e = (np.array(v) for v in V(x, random.uniform(0, 20)))
        assert rate.item() == pytest.approx((-(e.T @ Q @ e) / 2 - w**2).item(), rel=1e-6, abs=1e-9)
        assert rate.item() <= 0


SIGNAL_BLOCKS = ((reference(), "r"), (uncertainty(), "Delta"))


@given(st.floats(0.0, 30.0))
def test_reference_and_uncertainty_come_with_their_derivatives(t: float) -> None:
    for block, first in SIGNAL_BLOCKS:
        f = function(block, "y")
        h = 1e-5
        here, before, after = (np.array(f([], [t + s * h], numbers(block))).ravel() for s in (0, -1, 1))
        np.testing.assert_allclose(here[1:], (after - before)[:-1] / (2 * h), atol=1e-9)
        assert next(iter(block.y)) == first


def test_pretension_leaves_the_difference_of_forces_alone() -> None:
    """It acts in the null space: −Φ′₁u₁ + Φ′₂u₂ = β whatever k_c."""
    block = backstepping()
    f = ca.Function("f", [block.u.vector(), block.p.vector()], [block.y.vector()])
    L = ca.SX.sym("L")
    curve = {name: parameter.default for name, parameter in NGUYEN2019.parameters.items()}
    Phi = NGUYEN2019.Phi_S(L, Symbols({k: ca.SX(v) for k, v in curve.items()}))
    derivative = ca.Function("d", [L], [ca.jacobian(Phi, L)])
    inputs = [2.61, 0.01, 2.018, 2.012, 2.63, 0.001, 0, 0, 0.005, 0.001]
    slope = [float(derivative(length)) for length in inputs[2:4]]
    betas = []
    for k_c in (0.0, 5.0):
        u1, u2, _ = np.array(f(inputs, numbers(block, k_c=k_c))).ravel()
        betas.append(-slope[0] * u1 + slope[1] * u2)
        assert max(abs(u1), abs(u2)) < 0.9
    assert betas[0] == pytest.approx(betas[1], abs=1e-12)


@pytest.mark.parametrize("drive", DRIVES)
def test_every_signal_and_parameter_is_described(drive: str) -> None:
    truth = closed_loop(drive)
    assert all(name in SIGNALS for name in truth.y)
    for name, parameter in truth.parameters.items():
        assert parameter.sentence, name
        assert parameter.source, name
        assert parameter.unit, name
