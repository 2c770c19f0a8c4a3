"""Levant's differentiators: homogeneous, exact without noise while L exceeds the input's rate, linear at e = 0."""

import math
from collections.abc import Callable, Mapping

import casadi as ca
import numpy as np
import pytest

from hillobs.codegen.stepper import NODES, functions
from hillobs.model.block import Block, Symbols, symbols
from hillobs.observers.conditions import FACTS, check
from hillobs.observers.levant import PARAMETERS, joint, muscle, theorem
from independent.levant import LAMBDA, follow

CHAINS = {"joint": joint(), "muscle": muscle()}
# how often a chain is integrated from what is measured to the input, and its Lipschitz constant and ε
ORDER = {"joint": 2, "muscle": 1}
NUMBERS = {"joint": ("L_D", "eps_h"), "muscle": ("L_u1", "eps_L")}
Signal = Callable[[np.ndarray], np.ndarray]


def followed(
    kind: str, measured: Signal, known: Signal, numbers: Mapping[str, float], h: float, steps: int
) -> np.ndarray:
    """(steps, states) of a chain that sees exactly what is measured and known, at every stage."""
    block = CHAINS[kind]
    step = functions(block, (), list(block.u))["step"]
    t = np.arange(steps) * h
    staged = np.stack([[signal(t + node * h) for node in NODES] for signal in (measured, known)])
    start = np.array([numbers.get(f"initial.{name}", 0.0) for name in block.x])
    p = np.array([numbers.get(name, 0.0) for name in block.p])
    # x, the third argument, is the first result of the step before
    along = step.mapaccum("along", steps, [2], [0])
    path, _ = along(0, h, start, np.tile(p[:, None], steps), ca.DM(0, steps), _side_by_side(staged))
    return np.array(path).T


def _side_by_side(staged: np.ndarray) -> np.ndarray:
    """(inputs, stages × steps) of (inputs, stages, steps): the stages of a step next to each other."""
    return np.swapaxes(staged, 1, 2).reshape(len(staged), -1)


def sines(kind: str, amplitude: float, w: float) -> list[Signal]:
    """What is measured, and its derivatives down to the input amplitude · sin(wt); nothing else moves the chain."""
    n = ORDER[kind]

    def derivative(i: int) -> Signal:
        return lambda t: amplitude * w ** (i - n) * np.sin(w * t + (i - n) * math.pi / 2)

    return [derivative(i) for i in range(n + 1)]


def nothing(t: np.ndarray) -> np.ndarray:
    return 0 * t


def started(kind: str, signals: list[Signal]) -> dict[str, float]:
    """A start where the chain's first states are right; that of the input is 0."""
    names = list(CHAINS[kind].x)[:-1]
    return {f"initial.{name}": float(signal(np.zeros(1))[0]) for name, signal in zip(names, signals, strict=False)}


@pytest.mark.parametrize("kind", CHAINS)
def test_the_chain_is_the_printed_differentiator(kind: str) -> None:
    """An independent text, through a wrong start, with noise and a known acceleration."""
    L, eps = NUMBERS[kind]
    noise = np.random.default_rng(3).normal(0, 1e-3, 4000)

    def known(t: np.ndarray) -> np.ndarray:
        return 0.1 * np.cos(t)

    def measured(t: np.ndarray) -> np.ndarray:
        return 0.3 * np.sin(t) + noise[np.asarray(t / 0.0025 + 0.5, dtype=int)]

    numbers = {L: 0.6, eps: 0.02}
    ours = followed(kind, measured, known, numbers, 0.005, 1000)
    place = len(CHAINS[kind].x) - 2
    unit = np.eye(place + 2)[place]
    theirs = follow(np.zeros(place + 2), measured, lambda t: unit * known(t), 0.6, 0.02, 0.005, 1000)
    np.testing.assert_allclose(ours, theirs[1:], rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", CHAINS)
def test_the_chain_is_homogeneous(kind: str) -> None:
    """Time η times as slow makes lengths ηⁿ⁺¹ times as large; L κ times as large makes all κ times as large."""
    n, (L, eps), eta, kappa = ORDER[kind], NUMBERS[kind], 2.0, 8.0
    signals = sines(kind, 0.5, 1.3)
    base = followed(kind, signals[0], nothing, {L: 1.0, eps: 0.02}, 0.01, 800)
    slow = followed(kind, lambda t: eta ** (n + 1) * signals[0](t / eta), nothing, {L: 1.0, eps: 0.02 * eta}, 0.02, 800)
    weights = eta ** (n + 1.0 - np.arange(n + 1))
    np.testing.assert_allclose(slow, base * weights, rtol=0, atol=1e-11)
    large = followed(kind, lambda t: kappa * signals[0](t), nothing, {L: kappa, eps: 0.02}, 0.01, 800)
    np.testing.assert_allclose(large, kappa * base, rtol=0, atol=1e-11)


@pytest.mark.parametrize("kind", CHAINS)
def test_without_noise_the_error_falls_with_the_step_by_the_orders_of_the_chain(kind: str) -> None:
    """Of x̂₁, x̂₂, Δ̂ as h³, h², h, of x̂₃, û₁ as h², h.

    ε = 8h keeps the inner stages of RK4, which are off by h²/8 ẍ₁, within the layer of Lε³.
    """
    n, (L, eps), w, T = ORDER[kind], NUMBERS[kind], 1.0, 12.0
    signals = sines(kind, 0.8, w)
    errors = []
    for steps in (3000, 6000, 12000):
        h = T / steps
        path = followed(kind, signals[0], nothing, {L: 1.0, eps: 8 * h, **started(kind, signals)}, h, steps)
        t = h * np.arange(1, steps + 1)
        late = t > T / 2
        errors.append([np.abs(path[late, i] - signal(t[late])).max() for i, signal in enumerate(signals)])
    slopes = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    # the next order of the layer is smaller by ε w
    np.testing.assert_allclose(slopes, np.tile(n + 1.0 - np.arange(n + 1), (2, 1)), atol=0.05)


@pytest.mark.parametrize("kind", CHAINS)
@pytest.mark.parametrize("start", [0.02, 20.0])
def test_a_wrong_start_is_gone_in_a_finite_time(kind: str, start: float) -> None:
    """Which grows as the n + 1-st root of the error; a linear observer needs one that grows with how exact it is."""
    n, (L, eps) = ORDER[kind], NUMBERS[kind]
    unit = start ** (1 / (n + 1))
    h = 1e-3 * unit
    path = followed(kind, lambda t: start + 0 * t, nothing, {L: 1.0, eps: 2 * h}, h, 10_000)
    # after 8 units the error was in the layer, whose poles then took e⁻⁽⁸⁰⁰ᵗ⁾
    assert np.abs(path[8_000:, 0] - start).max() < 1e-12 * start


def triangle(rate: float) -> tuple[Signal, Signal]:
    """An input that goes up and down with this rate, period 4; and its integral."""

    def up(t: np.ndarray) -> np.ndarray:
        return rate * (1 - np.abs(np.mod(t, 4) - 2))

    def integral(t: np.ndarray) -> np.ndarray:
        s = np.mod(t, 4)
        first = s**2 / 2 - s
        second = 3 * s - s**2 / 2 - 4
        return rate * np.where(s < 2, first, second)

    return up, integral


@pytest.mark.parametrize(("rate", "follows"), [(0.5, True), (0.95, True), (1.2, False), (2.0, False)])
def test_the_theorem_says_which_inputs_are_followed(rate: float, follows: bool) -> None:
    signal, integral = triangle(rate)
    eps = 0.004
    path = followed("muscle", integral, nothing, {"L_u1": 1.0, "eps_L": eps}, eps / 2, 10_000)
    t = eps / 2 * np.arange(1, 10_001)
    error = np.abs(path[:, 1] - signal(t))[t > 8]
    # in the layer the error is of the order of ε u̇; beyond its speed û loses the input for a part of each turn
    assert (error.max() < 20 * eps) == follows
    assert (error.max() > 0.1 * rate) == (not follows)
    p, facts = symbols(PARAMETERS), symbols(FACTS)
    values = {**dict.fromkeys(p, 1.0), **dict.fromkeys(FACTS, math.nan), "sup_du1": rate}
    (condition,) = check(theorem(p, facts), Symbols({**p, **facts}), values)
    assert condition.holds == follows


@pytest.mark.parametrize("kind", CHAINS)
def test_in_its_layer_the_chain_is_a_stable_linear_observer(kind: str) -> None:
    block, n, (_, eps) = CHAINS[kind], ORDER[kind], NUMBERS[kind]
    A = ca.Function("A", [block.x.vector(), block.u.vector(), block.p.vector()], [_slopes(block)])
    p = [1.0 if name != eps else 0.1 for name in block.p]
    poles = np.linalg.eigvals(np.array(A([0.0] * (n + 1), [0.0, 0.0], p)))
    # sⁿ⁺¹ + λ₀ sⁿ/ε + …
    np.testing.assert_allclose(np.poly(poles), [1, *(c / 0.1**i for i, c in enumerate(LAMBDA[n], 1))], rtol=1e-9)
    assert poles.real.max() < -3


def _slopes(block: Block) -> ca.SX:
    return ca.jacobian(block.dx.vector(), block.x.vector())
