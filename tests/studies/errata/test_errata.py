"""The corrections proved: identities of the equations at random points, and the study's own numbers."""

import math
import re
from collections.abc import Mapping
from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

from hillobs.model.block import Block, Symbols
from hillobs.model.control.backstepping import PARAMETERS, backstepping, riccati
from hillobs.model.curves import NGUYEN2019, NGUYEN2019_PRINTED
from hillobs.model.dialect import root, sg
from hillobs.model.loops.closed_loop import closed_loop
from hillobs.model.plant import plant as plant_of
from hillobs.model.symbols import STATES, hat
from hillobs.observers import OBSERVERS
from hillobs.studies.cli.reports.errata import tables
from hillobs.studies.errata import printed
from hillobs.studies.errata import run as study
from hillobs.studies.scenarios.layers import Layer, layer
from hillobs.studies.simulate.run import simulate

POINTS = 200
CONTROLLER, OBSERVER = tuple(printed.CONTROLLER), tuple(printed.OBSERVER)
RANGES = {
    "x1": (2.55, 2.8), "x2": (-0.3, 0.3), "x3": (2.005, 2.06), "x4": (2.005, 2.06),
    "r": (2.6, 2.7), "dr": (-0.3, 0.3), "ddr": (-0.3, 0.3), "dddr": (-0.3, 0.3),
    "Delta": (-0.1, 0.1), "dDelta": (-0.1, 0.1), "u1": (-0.2, 0.2), "u2": (-0.2, 0.2),
    "x1_hat": (2.55, 2.8), "x2_hat": (-0.3, 0.3), "x3_hat": (2, 2.07), "x4_hat": (2, 2.07),
    "Delta_hat": (-0.1, 0.1), "u1_hat": (-0.2, 0.2), "u2_hat": (-0.2, 0.2),
    "l_a": (-0.5, 0.6), "r_a0": (0, 21), "k_1": (-0.1, 11), "r_a1": (0, 21), "k_2": (-0.1, 11), "r_a2": (0, 21),
    "y1": (2.55, 2.8), "y2": (0, 0.9), "y3": (0, 0.9),
    "L_S1": (2, 2.07), "L_S2": (2, 2.07),
}  # fmt: skip


def points(names, rng, ranges: Mapping[str, tuple[float, float]] = RANGES) -> np.ndarray:
    return np.array([rng.uniform(*ranges[name], POINTS) for name in names])


def parameters(block: Block, rng, fixed: Mapping[str, float]) -> np.ndarray:
    """Random values around the defaults, the tendon's as they are; `fixed` by name."""
    rows = []
    for name, parameter in block.parameters.items():
        if name in fixed or name.startswith("muscle"):
            rows.append(np.full(POINTS, fixed.get(name, parameter.default)))
        else:
            rows.append(parameter.default * rng.uniform(0.8, 1.25, POINTS))
    return np.array(rows)


def evaluate(expressions: Symbols, *groups: tuple[Symbols, np.ndarray]) -> dict[str, np.ndarray]:
    """Each expression at the points; a group is symbols and their values, a row each."""
    arguments = [group.vector() for group, _ in groups]
    values = ca.Function("f", arguments, [expressions.vector()])(*(ca.DM(v) for _, v in groups))
    return dict(zip(expressions, np.array(values), strict=True))


def difference(left: Mapping[str, np.ndarray], right: Mapping[str, np.ndarray]) -> float:
    assert list(left) == list(right)
    return max(float(np.max(abs(left[name] - right[name]) / np.maximum(1, abs(right[name])))) for name in left)


# ---------------------------------------------------------------- the 0/1 Blocks


@pytest.mark.parametrize(
    ("right", "switched", "switches"),
    [
        (backstepping, printed.backstepping_as_printed, CONTROLLER),
        (OBSERVERS["adaptive_sliding_mode"].block, printed.adaptive_as_printed, OBSERVER),
    ],
)
def test_all_corrections_together_are_the_corrected_block(right, switched, switches):
    right, switched = right(), switched()
    assert (list(switched.x), list(switched.u), list(switched.y)) == (list(right.x), list(right.u), list(right.y))
    assert list(switched.p) == [*right.p, *switches]
    x, u, p = (points(right.x, np.random.default_rng(1)), points(right.u, np.random.default_rng(2)), None)
    p = parameters(right, np.random.default_rng(3), {"k_c": 3.0, "leak": 0.5})

    def numbers(block: Block, group: str, extra: np.ndarray) -> dict[str, np.ndarray]:
        return evaluate(getattr(block, group), (block.x, x), (block.u, u), (block.p, np.vstack([p, extra])))

    for group in ("y", "dx", "guards"):
        expected = numbers(right, group, np.zeros((0, POINTS)))
        if not expected:
            continue
        assert difference(numbers(switched, group, np.ones((len(switches), POINTS))), expected) < 1e-13
    moved = "dx" if right.x else "y"
    expected = numbers(right, moved, np.zeros((0, POINTS)))
    for i in range(len(switches)):
        one_printed = np.ones((len(switches), POINTS))
        one_printed[i] = 0
        assert difference(numbers(switched, moved, one_printed), expected) > 1e-3


# ---------------------------------------------------------------- error dynamics


class Errors:
    """ė = ẋ − x̂̇ of an observer, the plant's own equations substituted, at random points."""

    def __init__(self, observer: Block, switches: Mapping[str, float] | None = None, **fixed: float) -> None:
        rng = np.random.default_rng(7)
        plant = plant_of()
        # y₁ = x₁, y₂ = Φ_S(x₃), Φ_S⁻¹(y₂) = x₃ …
        seen = {"y1": plant.x.x1, "y2": plant.y.Phi_S1, "y3": plant.y.Phi_S2, "L_S1": plant.x.x3, "L_S2": plant.x.x4}
        y = [seen[port] for port in observer.u]
        self.observer, self.o, self.p = observer, Symbols({**plant.x, **observer.x, **plant.u}), observer.p
        dx_hat = Symbols(
            zip(observer.dx, ca.substitute(list(observer.dx.values()), list(observer.u.values()), y), strict=True)
        )
        self.de = [plant.dx[x] - dx_hat[hat(x)] for x in STATES]
        self.dx_hat = dx_hat
        # inside all limits, so that the equations are the paper's; y₁ = x₁ etc. without noise
        ranges = {**RANGES, "l_a": (-0.2, 0.6), "k_1": (0, 7.9), "k_2": (0, 7.9), "r_a0": (0, 15.9)}
        defaults = [parameter.default for parameter in plant.parameters.values()]
        assert defaults[list(plant.p).index("m")] == 1
        given = parameters(observer, rng, {"m": 1.0, **(switches or {}), **fixed})
        self.groups = (
            (self.o, points(self.o, rng, ranges)),
            (plant.p, np.tile(np.array(defaults)[:, None], POINTS)),
            (observer.p, given),
        )

    def e(self, i: int) -> ca.SX:
        return self.o[f"x{i}"] - self.o[f"x{i}_hat"]

    def gap(self, *expected: ca.SX) -> np.ndarray:
        """Largest |ė − expected| of each component."""
        names = [f"e{i}" for i in range(1, 5)]
        gaps = Symbols({n: left - right for n, left, right in zip(names, self.de, expected, strict=True)})
        return np.array([np.max(abs(row)) for row in evaluate(gaps, *self.groups).values()])


EXACT = pytest.approx(np.zeros(4), abs=1e-12)


def test_error_dynamics_of_the_high_gain_observer():
    d = Errors(OBSERVERS["high_gain"].block())
    o, p, e1, e2, e3, e4 = d.o, d.p, *(d.e(i) for i in range(1, 5))
    eps = p.eps_h
    assert (
        d.gap(
            e2 - p.h11 / eps * e1,
            o.Delta - o.Delta_hat - p.h12 / eps**2 * e1,
            e2 + o.u1 - o.u1_hat - p.h21 / p.eps_L * e3,
            -e2 + o.u2 - o.u2_hat - p.h31 / p.eps_L * e4,
        )
        == EXACT
    )


def test_error_dynamics_of_the_sliding_mode_observer():
    d = Errors(OBSERVERS["sliding_mode"].block())
    o, p, e1, e2, e3, e4 = d.o, d.p, *(d.e(i) for i in range(1, 5))
    v11, v12 = p.lambda11 * root(e1) * sg(e1, p.delta_s), p.alpha11 * sg(e1, p.delta_s)
    v2, v3 = p.alpha2 * sg(e3, p.delta_L), p.alpha3 * sg(e4, p.delta_L)
    load = (e2 - v11, o.Delta - v12)
    # [de3], [de4] with −v₂, −v₃; as printed, + (O1)
    assert d.gap(*load, e2 + o.u1 - v2, -e2 + o.u2 - v3) == EXACT
    assert (d.gap(*load, e2 + o.u1 + v2, -e2 + o.u2 + v3)[2:] > 0.5).all()


def adaptive(d: Errors) -> tuple[ca.SX, ...]:
    """φ and the three injections of the adaptive observer."""
    p, L = d.p, d.p.l0 + d.o.l_a
    e1, e3, e4 = d.e(1), d.e(3), d.e(4)
    phi = -d.dx_hat.l_a / L * e1
    beta = p.beta0 * L * sg(e1, p.delta_1)
    return phi, beta, (d.o.k_1 + p.eta1) * sg(e3, p.delta_L), (d.o.k_2 + p.eta2) * sg(e4, p.delta_L)


def test_error_dynamics_of_the_adaptive_observer():
    d = Errors(OBSERVERS["adaptive_sliding_mode"].block())
    o, e1, e2 = d.o, d.e(1), d.e(2)
    phi, v1, v3, v4 = adaptive(d)
    alpha = d.p.alpha0 * ca.sqrt(d.p.l0 + o.l_a) * root(e1) * sg(e1, d.p.delta_1)
    # [de1a] with + φ (O7), [de2a], [de3a] and [de4a] with u₁, u₂ (O6)
    assert d.gap(e2 - alpha + phi, o.Delta - v1, e2 + o.u1 - v3, -e2 + o.u2 - v4) == EXACT
    printed = d.gap(e2 - alpha - phi, o.Delta - v1, e2 - v3, -e2 - v4)
    assert printed[1] < 1e-12
    assert (printed[[0, 2, 3]] > 0.1).all()


def test_error_dynamics_of_the_adaptive_observer_as_printed():
    d = Errors(printed.adaptive_as_printed(), {"O2": 0.0, "O3": 0.0, "O4": 0.0, "O5": 0.0, "O8": 1.0})
    o, e1, e2 = d.o, d.e(1), d.e(2)
    phi, v1, v3, v4 = adaptive(d)
    alpha = d.p.alpha0 * ca.sqrt(d.p.l0 + o.l_a) * root(e1) * sg(e1, d.p.delta_1)
    # what the injections must balance: ẋ₂, x₂ + u₁, −x₂ + u₂ instead of Δ, u₁, u₂
    assert d.gap(e2 - alpha + phi, pair_acceleration(d) - v1, o.x2 + o.u1 - v3, -o.x2 + o.u2 - v4) == EXACT
    assert (d.gap(e2 - alpha + phi, o.Delta - v1, e2 + o.u1 - v3, -e2 + o.u2 - v4)[1:] > 0.1).all()
    # filters at rest hold minus the injection   (O3, O5)
    filters = {"Delta_hat": v1, "u1_hat": v3, "u2_hat": v4}
    rest = Symbols({n: d.p.tau_a * d.dx_hat[n] + o[n] + v for n, v in filters.items()})
    assert max(np.max(abs(row)) for row in evaluate(rest, *d.groups).values()) < 1e-12


def pair_acceleration(d: Errors) -> ca.SX:
    """(Φ_S2 − Φ_S1)/m + Δ at the points of `d`, for m = 1 and the paper's tendon."""
    p = Symbols({name: ca.SX(parameter.default) for name, parameter in NGUYEN2019.tendon.items()})
    return NGUYEN2019.Phi_S(d.o.x4, p) - NGUYEN2019.Phi_S(d.o.x3, p) + d.o.Delta


# ---------------------------------------------------------------- the controller


def lyapunov_gap(controller: Block, switches: Mapping[str, float]) -> float:
    """Largest |V̇_a + ½eᵀ(Q + KᵀRK)e + γw²| along the loop of plant and controller."""
    rng = np.random.default_rng(11)
    u, p, m = controller.u, controller.p, controller.p.m
    Phi_S = [NGUYEN2019.Phi_S(x, p.part(f"muscle{j}")) for j, x in enumerate((u.x3, u.x4), start=1)]
    force = Phi_S[1] - Phi_S[0]
    e = ca.vertcat(u.x1 - u.r, u.x2 - u.dr)
    K, P = riccati(p)
    w = force + m * u.Delta - m * u.ddr + K @ e
    V = (e.T @ P @ e + w**2) / 2
    rates = {
        u.x1: u.x2, u.x2: force / m + u.Delta, u.x3: u.x2 + controller.y.u1, u.x4: -u.x2 + controller.y.u2,
        u.r: u.dr, u.dr: u.ddr, u.ddr: u.dddr, u.Delta: u.dDelta,
    }  # fmt: skip
    dV = sum((ca.jacobian(V, x) * rate for x, rate in rates.items()), ca.SX(0))
    Q = p.q * ca.SX.eye(2) + p.R * K.T @ K
    gap = Symbols(gap=dV + e.T @ Q @ e / 2 + p.gamma * w**2)
    p_values = parameters(controller, rng, {"u_max": 1e9, "k_c": 3.0, **switches})
    return float(np.max(abs(evaluate(gap, (u, points(u, rng)), (p, p_values))["gap"])))


def test_lyapunov_function_decreases_with_the_corrected_controller_only():
    assert lyapunov_gap(backstepping(), {}) < 1e-11
    as_printed = printed.backstepping_as_printed()
    corrected = dict.fromkeys(CONTROLLER, 1.0)
    assert lyapunov_gap(as_printed, corrected) < 1e-11
    assert lyapunov_gap(as_printed, dict.fromkeys(CONTROLLER, 0.0)) > 0.1
    for name in CONTROLLER:
        assert lyapunov_gap(as_printed, {**corrected, name: 0.0}) > 0.1, name


def error_dynamics() -> np.ndarray:
    """M of d/dτ (e, w) = M (e, w), with the controller's default numbers."""
    p = Symbols({name: ca.SX(parameter.default) for name, parameter in PARAMETERS.items()})
    K, P = (np.array(ca.DM(matrix)) for matrix in riccati(p))
    m, gamma = float(p.m), float(p.gamma)
    A, B = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1 / m]])
    return np.block([[A - B @ K, B], [-B.T @ P, -gamma * np.eye(1)]])


# of (e, w) together, docs/errata.md C11
POLES = np.array([-0.8717 - 6.0665j, -0.8717 + 6.0665j, -0.4765])


def test_the_poles_of_the_closed_loop_are_those_of_tracking_error_and_force_error_together():
    loop = closed_loop()
    # a reference and an uncertainty at rest, so that the loop has an equilibrium
    numbers = {name: parameter.default for name, parameter in loop.parameters.items()}
    numbers |= {"reference.amplitude": 0.0, "uncertainty.amplitude": 0.0}
    p = Symbols({name: ca.SX(parameter.default) for name, parameter in NGUYEN2019.tendon.items()})
    # Φ_S2 = Φ_S1 − mΔ_Φ,  m = 1
    x3 = 2.018
    x4 = float(ca.evalf(NGUYEN2019.Phi_S_inv(NGUYEN2019.Phi_S(ca.SX(x3), p) - numbers["uncertainty.offset"], p)))
    f = Symbols({name: loop.dx[name] for name in loop.x}).vector()
    arguments = [loop.x.vector(), loop.u.vector(), loop.p.vector()]
    linearised = ca.Function("linearised", arguments, [f, ca.jacobian(f, loop.x.vector())])
    rest, jacobian = linearised(
        [numbers["reference.offset"], 0, x3, x4], np.zeros(len(loop.u)), [numbers[name] for name in loop.p]
    )
    np.testing.assert_allclose(np.array(rest), 0, atol=1e-14)
    poles = np.sort_complex(np.linalg.eigvals(np.array(jacobian)))
    # the fourth direction is common tension, which the paper's law leaves as it is
    np.testing.assert_allclose(poles, [*POLES, 0], atol=1e-4)
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(error_dynamics())), POLES, atol=1e-4)
    alone = np.linalg.eigvals(error_dynamics()[:2, :2])
    np.testing.assert_allclose(np.sort_complex(alone), [-0.6099 - 0.4531j, -0.6099 + 0.4531j], atol=1e-4)


@pytest.mark.parametrize("times", [0.0, 1.0, 5.0])
def test_the_tracking_error_of_a_run_is_the_exponential_of_its_poles_whatever_the_uncertainty(times):
    offset = 0.005 * times
    changes = {"uncertainty.offset": offset, "uncertainty.amplitude": offset}
    run = simulate("paper-clean", ["high_gain"], changes)
    tau, error = run.time.values, (run.x.sel(state="x1") - run.r).values
    # e = (x₁ − r, x₂ − ṙ),  w = ζ + K e,  ζ = mΔ_Φ at τ = 0: equal forces, r̈ = 0
    M, m = error_dynamics(), PARAMETERS["m"].default
    e = np.array([2.6 - 2.6315, 0 - 0.005])
    K = -m * M[1, :2]
    start = np.array([*e, m * offset + K @ e])
    exact = np.array([expm(M * t)[0] @ start for t in tau])
    # RK4: |λ|⁵h⁴/120 · 0.03/0.87 = 2e-13 for |λ| = 6.13, h = 5e-4; rounding of x₁ ≈ 2.6: 4e-16/(0.48 h) = 2e-12
    np.testing.assert_allclose(error, exact, atol=1e-11, rtol=0)
    # in the end the slowest pole alone is left: a factor 2.5935 in two time units
    later = np.array([np.abs(error[tau >= t]).max() for t in (12, 14, 16)])
    np.testing.assert_allclose(later[:-1] / later[1:], math.exp(2 * 0.4765), rtol=1e-3)


# ---------------------------------------------------------------- Φ_S as printed


def test_printed_decimals_break_the_toe():
    assert printed.printed_toe(Fraction(2)) == Fraction("0.06")
    assert printed.printed_toe(Fraction("2.04")) == Fraction("0.565395137536")
    assert printed.printed_toe(Fraction(2), 1) == Fraction("0.13")
    rows = {row.where: row for row in study.joints()}
    assert [rows[f"Φ{prime}_S(2.04)"].meant for prime in ("", "′", "″")] == [Fraction(1, 2), Fraction("19.2308"), 0]
    assert 1e-7 < rows["Φ_S(2)"].rounding < 1e-6


def test_printed_curve_set_has_the_printed_decimals():
    p = Symbols({name: ca.SX(parameter.default) for name, parameter in NGUYEN2019_PRINTED.tendon.items()})
    jump = [float(ca.evalf(NGUYEN2019_PRINTED.Phi_S(ca.SX(L), p))) for L in (1.9999999999, 2, 2.0399999999, 2.04)]
    np.testing.assert_allclose(jump, [0, 0.06, 0.5653951375, 0.5], atol=1e-6)


# ---------------------------------------------------------------- the study


@pytest.mark.numerics
def test_what_each_printed_term_does():
    done = []
    results = study.errata(done.append)
    assert done == sorted(done)
    assert done[-1] == 1
    check_controllers({row.variant.name: row for row in results if isinstance(row, study.Tracking)})
    check_observers({row.variant.name: row for row in results if isinstance(row, study.Estimation)})
    legend, *others = tables(results)
    assert legend.row_count == len(CONTROLLER) + len(OBSERVER)
    kinds = (study.Tracking, study.Estimation, study.Estimation, study.Joint)
    assert [table.row_count for table in others] == [sum(isinstance(r, kind) for r in results) for kind in kinds]


def check_controllers(rows: Mapping[str, study.Tracking]) -> None:
    assert len(rows) == 2 + 2 * len(CONTROLLER)
    assert rows["corrected"].largest == pytest.approx(7.1e-4, rel=0.01)
    assert rows["corrected"].periodic < 1e-9
    assert rows["as printed"].largest == pytest.approx(6.8e-3, rel=0.01)
    assert rows["as printed"].periodic == pytest.approx(5.1e-3, rel=0.03)
    assert rows["as printed"].periodic_rms == pytest.approx(3.7e-3, rel=0.03)
    alone = [rows[f"{name} printed"].periodic_rms for name in CONTROLLER]
    np.testing.assert_allclose(alone, (3.4e-4, 7.7e-5, 3.8e-3, 8.2e-5), rtol=0.02)
    assert not any(row.failure for row in rows.values())


def check_observers(rows: Mapping[str, study.Estimation]) -> None:
    found = {name: [nearest.signal for nearest in row.nearest.values()] for name, row in rows.items()}
    assert found["corrected"] == ["Δ", "u₁", "u₂"]
    assert found["as printed"] == ["−ẋ₂", "−(x₂ + u₁)", "−(u₂ − x₂)"]
    assert found["O2 printed"] == ["ẋ₂", "u₁", "u₂"]
    assert found["O3 printed"] == ["−Δ", "u₁", "u₂"]
    assert found["O4 printed"] == ["Δ", "(x₂ + u₁)", "(u₂ − x₂)"]
    assert found["O5 printed"] == ["Δ", "−u₁", "−u₂"]
    assert rows["as printed"].nearest["u1_hat"].distance < 1e-5
    assert rows["corrected"].rmse["u1"] == pytest.approx(7.4e-4, rel=0.01)
    assert rows["as printed"].rmse["u1"] == pytest.approx(3.95e-3, rel=0.01)
    assert rows["O8 printed"].guards["L_min"] > 19


def test_an_observer_that_diverges_says_when(monkeypatch):
    wild = {"adaptive_as_printed": {"alpha0": 1e25}}
    monkeypatch.setattr(study, "layers", lambda name, changes: (name, [layer(name, wild), Layer("", changes)]))
    row = study._estimation(study.Variant("wild", ()), lambda done: None)
    assert re.fullmatch(r"diverges at τ = [\d.]+", row.failure)
    assert np.isnan(row.rmse["x2"])
    assert row.nearest["Delta_hat"].signal == "nothing"
