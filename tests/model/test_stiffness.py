"""How fast a tendon comes to rest, and the force that an activation makes."""

import casadi as ca
import numpy as np
import pytest

from hillobs.model.block import Symbols
from hillobs.model.curves import CURVES, SIMULATED
from hillobs.model.muscle import activated_muscle
from hillobs.model.signals.dynamics import activation_dynamics

NUMBERS = {"pennation": 0.3}


@pytest.mark.parametrize("name", SIMULATED)
def test_stiffness_is_what_differences_of_the_rate_say(name: str) -> None:
    """Central differences of 1e−7 are good to 1e−7 of the rate: 1e−16/1e−7 of rounding, 1e−14 of curvature."""
    curves = CURVES[name]
    block = activated_muscle(curves, oblique="l_opt" in curves.parameters)
    values = {key: NUMBERS.get(key, parameter.default) for key, parameter in block.parameters.items()}
    told = ca.Function(
        "told",
        [block.x.vector(), block.u.vector(), block.p.vector()],
        [block.dx.L_S, block.y.stiffness, block.guards.z_limit],
    )
    step, tried = 1e-7, 0
    for stretch in (1.004, 1.008, 1.012):
        for a in (0.3, 0.6, 0.9):
            L_S = stretch * values["L_slack"]

            def at(length: float, L_m: float = L_S + 1.0, a: float = a) -> list[float]:
                return [float(value) for value in told(length, [L_m, 0.0, a], list(values.values()))]

            _, stiffness, limited = at(L_S)
            rate = (at(L_S - step)[0] - at(L_S + step)[0]) / (2 * step)
            assert stiffness == pytest.approx(rate, rel=1e-5, abs=1e-5)
            assert not limited or stiffness == 0
            tried += not limited
    assert tried >= 3


@pytest.mark.parametrize("name", SIMULATED)
def test_the_force_of_an_activation_asks_for_that_activation(name: str) -> None:
    curves = CURVES[name]
    p = Symbols({key: ca.SX(parameter.default) for key, parameter in curves.parameters.items()})
    a, L_C, u = (ca.SX.sym(key) for key in ("a", "L_C", "u"))
    again = ca.Function("again", [a, L_C, u], [curves.activation(curves.force(L_C, a, u, p), L_C, u, p)])
    for activation in (0.05, 0.4, 1.0):
        for length in (0.8, 1.0, 1.2):
            for velocity in (-0.3, 0.0, 0.1):
                # Millard's are fitted by splines in between; others are closed forms
                assert float(again(activation, length, velocity)) == pytest.approx(activation, rel=1e-9)


def test_activation_rises_and_falls_with_its_time_constants() -> None:
    """At a = ⅓ the factor ½ + 3/2 a is 1: ȧ = (e − a)/τ, and tanh(10 · ⅔) is 1 to 4e−6, tanh(10 · ⅓) to 3e−3."""
    block = activation_dynamics(rate=10.0)
    rate = ca.Function("rate", [block.x.vector(), block.u.vector(), block.p.vector()], [block.dx.a])
    p = [parameter.default for parameter in block.parameters.values()]
    assert float(rate(1 / 3, 1.0, p)) == pytest.approx((1 - 1 / 3) / 0.15, rel=1e-5)
    assert float(rate(1 / 3, 0.0, p)) == pytest.approx(-1 / 3 / 0.60, rel=1e-2)
    for e in (0.0, 0.4, 1.0):
        assert float(rate(e, e, p)) == 0
    # it never leaves [0, 1]
    assert all(float(rate(0.0, e, p)) >= 0 for e in np.linspace(0, 1, 5))
    assert all(float(rate(1.0, e, p)) <= 0 for e in np.linspace(0, 1, 5))
