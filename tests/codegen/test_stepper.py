"""The stepper as mathematics, and its C as the same mathematics."""

import platform

import casadi as ca
import numpy as np
import pytest

from hillobs.codegen.shared_library import compile_functions
from hillobs.codegen.stepper import functions
from hillobs.model.block import Block, BlockError, Parameter, Symbols, symbols
from hillobs.model.loops.closed_loop import closed_loop
from hillobs.model.plant import DRIVES
from hillobs.model.sensors import NOISE_CHANNELS, SENSED, sensors
from hillobs.model.signals.pulses import PULSES
from hillobs.model.symbols import MEASURED, QUANTITIES, hat
from hillobs.observers import OBSERVERS, baseline_estimator, estimator
from hillobs.observers.score import score
from hillobs.observers.tendons import LENGTHS, tendons

pytestmark = pytest.mark.numerics

HELD = (*NOISE_CHANNELS, *PULSES, "window", "sample")


def pendulum() -> Block:
    """Smooth, nonlinear, driven by t, with a parameter: ẋ = v, v̇ = −k sin x + cos t."""
    x, u, p = symbols("x v"), symbols("t"), symbols("k")
    return Block(
        "pendulum",
        x=x,
        u=u,
        p=p,
        parameters={"k": Parameter(4.0, "stiffness", "test")},
        dx=Symbols(x=x.v, v=-p.k * ca.sin(x.x) + ca.cos(u.t)),
        x0=Symbols(x=ca.SX(1), v=ca.SX(0)),
        y=Symbols(x=x.x),
    )


def march(
    table: dict[str, ca.Function], p: list[float], h: float, steps: int, start: int = 0, x: ca.DM | None = None
) -> ca.DM:
    x = table["init"](0, p, [], []) if x is None else x
    for k in range(start, start + steps):
        x, _ = table["step"](k * h, h, x, p, [], ca.DM(0, 4))
    return x


def test_the_order_of_convergence_is_four() -> None:
    table = functions(pendulum(), (), ())
    exact = march(table, [4.0], 1 / 4096, 4096 * 2)
    h = 1 / np.array([8, 16, 32, 64])
    errors = [float(ca.norm_2(march(table, [4.0], s, round(2 / s)) - exact)) for s in h]
    order = np.polyfit(np.log(h), np.log(errors), 1)[0]
    assert 3.8 <= order <= 4.3


def test_a_linear_system_is_advanced_by_the_fourth_order_exponential() -> None:
    """One RK4 step of ẋ = Ax is Σ (hA)ᵏ/k!, k ≤ 4, exactly."""
    A = np.array([[-1.0, 2.0, 0.0], [0.5, -3.0, 1.0], [0.0, 1.0, -0.5]])
    x = symbols("a b c")
    dx = Symbols(zip(x, ca.vertsplit(ca.SX(A) @ x.vector()), strict=True))
    table = functions(Block("linear", x=x, dx=dx), (), ())
    h, start = 0.1, np.array([1.0, -2.0, 0.5])
    after, _ = table["step"](0, h, start, [], [], ca.DM(0, 4))
    series = sum(np.linalg.matrix_power(h * A, k) / np.prod(np.arange(1, k + 1)) for k in range(5))
    np.testing.assert_allclose(np.array(after).ravel(), series @ start, rtol=1e-15, atol=1e-16)


def test_time_can_be_split_anywhere() -> None:
    table = functions(pendulum(), (), ())
    whole = march(table, [4.0], 0.01, 100)
    split = march(table, [4.0], 0.01, 63, 37, march(table, [4.0], 0.01, 37))
    assert np.array_equal(np.array(whole), np.array(split))


def test_jumps_change_only_their_own_states() -> None:
    x, u = symbols("slow sampled summed"), symbols("y")
    block = Block(
        "mixed",
        x=x,
        u=u,
        dx=Symbols(slow=-x.slow),
        next=Symbols(sampled=u.y),
        per_step=Symbols(summed=x.summed + u.y),
    )
    table = functions(block, (), ("y",))
    assert np.array_equal(np.array(table["sample"](0, [1, 2, 3], [], [], [7])).ravel(), [1, 7, 3])
    assert np.array_equal(np.array(table["each"](0, [1, 2, 3], [], [], [7])).ravel(), [1, 2, 10])
    after = np.array(table["step"](0, 0.1, [1, 2, 3], [], [], np.full((1, 4), 7))[0]).ravel()
    assert after[0] < 1
    assert np.array_equal(after[1:], [2, 3])


def test_an_input_that_no_one_provides_is_named() -> None:
    u = symbols("force")
    with pytest.raises(BlockError, match="no one provides the inputs force"):
        functions(Block("b", u=u, y=Symbols(f=u.force)), (), ("y1",))


def every_function() -> list[ca.Function]:
    tables = []
    for drive in DRIVES:
        truth = closed_loop(drive)
        table = functions(truth, HELD, (), SENSED)
        tables.append({role: rename(f, f"{drive}_{role}") for role, f in table.items()})
    for observer in (*(estimator(o.block()) for o in OBSERVERS.values()), baseline_estimator()):
        tables.append(functions(observer, HELD, (*MEASURED, *LENGTHS)))
    tables.append(functions(sensors(), HELD, SENSED))
    tables.append(functions(tendons(), HELD, MEASURED))
    scored = (*closed_loop().y, *(hat(name) for name in QUANTITIES))
    tables.append(functions(score(), HELD, scored))
    return [f for table in tables for f in table.values()]


def rename(f: ca.Function, name: str) -> ca.Function:
    inputs = f.sx_in()
    return ca.Function(name, inputs, f.call(inputs), f.name_in(), f.name_out())


# of what all processors of a kind have, only ARM's can round a product and a sum once
FUSED, NOT_FUSED = 1e-11, 1e-12
SCALAR = NOT_FUSED if platform.machine() == "x86_64" else FUSED


# that of one run at a time is held against the lanes in test_lanes.py too
@pytest.mark.parametrize(
    ("target", "tolerance"), [pytest.param("scalar", SCALAR, marks=pytest.mark.chaos), ("native", FUSED)]
)
def test_compiled_C_is_the_casadi_function(target: str, tolerance: float) -> None:
    """Every exported function, at points about a run, slack tendons included."""
    every = every_function()
    library = compile_functions(every, target)
    random = np.random.default_rng(3)
    worst = 0.0
    for function in every:
        for _ in range(40):
            row = []
            for i in range(function.n_in()):
                name, size = function.name_in(i), function.numel_in(i)
                value = random.uniform(0, 1, size)
                if name == "h":
                    value = np.full(size, 5e-4)
                elif name == "x":
                    value = random.choice([2.0, 2.018, 0.1], size) + 0.05 * random.normal(size=size)
                elif name == "p":
                    value = random.uniform(0.1, 1.2, size)
                row.append(value)
            compiled = np.concatenate([c.ravel() for c in library.call(function.name(), *row)])
            shaped = [ca.reshape(ca.DM(v), *function.size_in(i)) for i, v in enumerate(row)]
            expected = np.concatenate([np.array(r, float).ravel(order="F") for r in function.call(shaped)])
            assert np.array_equal(np.isfinite(compiled), np.isfinite(expected)), function.name()
            finite = np.isfinite(expected)
            scale = 1 + np.abs(expected[finite])
            worst = max(worst, np.max(np.abs(compiled[finite] - expected[finite]) / scale, initial=0.0))
    assert worst <= tolerance


def test_a_library_says_what_it_takes() -> None:
    x = ca.SX.sym("x", 2)
    library = compile_functions([ca.Function("norm", [x], [ca.sumsqr(x)])])
    assert library.call("norm", [[3.0, 4.0], [1.0, 0.0]])[0].tolist() == [[25.0], [1.0]]
    with pytest.raises(ValueError, match="sizes \\[2\\], not \\[3\\]"):
        library.call("norm", [1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="there are norm"):
        library.call("other", [1.0])
    sparse = ca.Function("sparse", [x], [ca.diag(x)])
    with pytest.raises(ValueError, match="must be dense"):
        compile_functions([sparse])
