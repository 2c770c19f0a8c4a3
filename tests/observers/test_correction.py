"""What the correction of the layers and the third order bring: laws of a steady motion."""

import functools
import math
from collections.abc import Mapping

import casadi as ca
import numpy as np
import pytest

from hillobs.codegen.bank import Bank
from hillobs.codegen.recordings.filters import CompiledBank
from hillobs.model.block import Block, Symbols, symbols
from hillobs.observers import OBSERVERS
from hillobs.observers.adaptive_sliding_mode import PARAMETERS as ADAPTIVE

pytestmark = pytest.mark.numerics

T, LONG = 0.01, 100.0
DELTA, U1, U2 = 0.1, 0.05, -0.03
SLIDING = ("sliding_mode", "adaptive_sliding_mode")
# width of the layer and height of the injection, the same for both: λ₁₁ = √(8α₁₁), β₀l₀ = α₁₁
WIDTH, ALPHA = 0.015, 0.6
BETA0, A_DUAL = (ADAPTIVE[name].default for name in ("beta0", "a_dual"))
GAINS = {
    "sliding_mode": {"alpha11": ALPHA, "lambda11": math.sqrt(8 * ALPHA), "delta_s": WIDTH, "tau_s": 0.1},
    # L rests at l₀, where l₀ − |Δ|/(aβ₀) = ε_a0
    "adaptive_sliding_mode": {
        "l0": ALPHA / BETA0,
        "eps_a0": ALPHA / BETA0 - DELTA / (A_DUAL * BETA0),
        "delta_1": WIDTH,
        "tau_a": 0.1,
    },
}


@functools.cache
def compiled(corrected: bool) -> CompiledBank:
    """Observers that are told tendon lengths and accelerations instead of forces."""
    u = symbols("z1 z2 acc")
    front = Block("measured", u=u, y=Symbols(y2=ca.SX(0), y3=u.acc, L_S1=u.z1, L_S2=u.z2))
    blocks = tuple(
        observer.block(corrected) for observer in (OBSERVERS[name] for name in (*SLIDING, "high_gain", "high_gain_3"))
    )
    return CompiledBank(Bank(("y1", "z1", "z2", "acc"), front, None, blocks))


def followed(
    observer: str, corrected: bool, given: Mapping[str, float], u1_rate: float = 0.0
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Estimates of a swinging mass under a constant Δ, with u₁ and u₂ constant or u₁ a ramp."""
    bank = compiled(corrected)
    t = np.arange(0, LONG, T)
    x1, z2 = 2.7 + 0.1 * np.sin(0.5 * t), 2.8 - 0.1 * np.sin(0.5 * t) + U2 * t
    # ẋ₃ = x₂ + u₁,  ẍ₁ = acc + Δ
    measured = [x1, x1 - 0.7 + U1 * t + u1_rate * t**2 / 2, z2, -0.025 * np.sin(0.5 * t) - DELTA]
    block = next(block for block in bank.bank.observers if block.name == observer)
    start = dict(zip(("x1_hat", "x2_hat", "x3_hat", "x4_hat"), (2.7, 0.05, 2.0, 2.8), strict=True))
    numbers = {f"initial.{name}": value for name, value in start.items()} | {"m": 1.0} | given
    values = [numbers.get(name, parameter.default) for name, parameter in block.parameters.items()]
    found = bank.follow(observer, values, 20).samples(t, np.stack(measured, axis=1)).y
    truth = {"x1_hat": x1, "x2_hat": 0.05 * np.cos(0.5 * t), "u1_hat": U1 + u1_rate * t, "u2_hat": U2 + 0 * t}
    truth |= {"x3_hat": measured[1], "x4_hat": z2, "Delta_hat": DELTA + 0 * t}
    late = t > LONG / 2
    return t[late], {name: (found[:, i] - truth[name])[late] for i, name in enumerate(block.y)}


@pytest.mark.parametrize("observer", SLIDING)
def test_in_a_layer_x2_is_wrong_by_v11_unless_corrected(observer: str) -> None:
    gains = {**GAINS[observer], "delta_L": 0.003}
    # α₁₁ sg(e₁) = Δ,  v₁₁ = λ₁₁|e₁|^½ sg(e₁)
    e = WIDTH * DELTA / (ALPHA - DELTA)
    v11 = math.sqrt(8 * ALPHA * e) * e / (WIDTH + e)
    assert v11 > 0.01
    _, plain = followed(observer, False, gains)
    np.testing.assert_allclose(plain["x2_hat"], -v11, rtol=2e-3)
    np.testing.assert_allclose(plain["u1_hat"], v11, rtol=2e-3)
    np.testing.assert_allclose(plain["u2_hat"], -v11, rtol=2e-3)
    np.testing.assert_allclose(plain["x1_hat"], -e, rtol=2e-3)
    _, corrected = followed(observer, True, gains)
    for name, error in corrected.items():
        assert np.abs(error).max() < 2e-5, name


def test_u_of_order_3_follows_a_ramp_without_lag() -> None:
    rate, eps = 0.004, 0.1
    _, second = followed("high_gain", False, {"eps_h": eps, "eps_L": eps}, rate)
    _, third = followed("high_gain_3", False, {"eps_h": eps, "eps_L": eps}, rate)
    # û₁ − u₁ → −2ε u̇₁, of a double pole
    np.testing.assert_allclose(second["u1_hat"], -2 * eps * rate, rtol=1e-3)
    assert np.abs(third["u1_hat"]).max() < 1e-3 * eps * rate
    for name in ("x2_hat", "Delta_hat", "u2_hat"):
        assert max(np.abs(second[name]).max(), np.abs(third[name]).max()) < 1e-5, name


@pytest.mark.parametrize("observer", SLIDING)
def test_the_correction_feeds_nothing_back(observer: str) -> None:
    """With a correction that never comes the estimates are those without, to the last bits."""
    _, plain = followed(observer, False, GAINS[observer])
    _, late = followed(observer, True, {**GAINS[observer], "tau_c": 1e30})
    for name, error in plain.items():
        np.testing.assert_allclose(late[name], error, atol=1e-12)
