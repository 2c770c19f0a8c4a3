"""Systems to observe: the pair at a point of each region, small ones whose answer is known, and their verdicts."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache

import casadi as ca
import numpy as np
from scipy.linalg import orth

from hillobs.model.arrays import Array
from hillobs.model.block import Block, Symbols, symbols
from hillobs.model.plant import plant as plant_of
from hillobs.model.system import PAIR
from hillobs.observers.observability import Verdict, augmented, judge, observability_matrix

Point = Mapping[str, float]

SENSORS = ("x1", "Phi_S1", "Phi_S2")
UNKNOWN = {"none": (), "none, a": (), "u": ("Delta", "u1", "u2"), "a": ("Delta", "a1", "a2")}
# the typical sizes of docs/observers.md#observability
SIZE = {"a1": 0.5, "a2": 0.1}

TAUT = {"x1": 2.6, "x2": 0.03, "x3": 2.018, "x4": 2.025, "Delta": 0.005, "u1": 0.02, "u2": -0.01, "a1": 0.5, "a2": 0.3}
REGIONS: dict[str, Point] = {
    "both taut": TAUT,
    "toe and linear": {**TAUT, "x1": 2.85, "x3": 2.047, "a1": 0.9, "x4": 2.018, "a2": 0.8},
    "1 slack": {**TAUT, "x3": 1.95},
    "2 slack": {**TAUT, "x4": 1.96},
    "both slack": {**TAUT, "x3": 1.95, "x4": 1.96},
}


@cache
def block(unknown: str, derivatives: int = 0) -> Block:
    """The pair with its unknown inputs and their derivatives as states."""
    return augmented(plant_of(PAIR, "given" if "a" in unknown else "virtual"), UNKNOWN[unknown], derivatives)


@cache
def function(unknown: str, outputs: tuple[str, ...], order: int, derivatives: int = 0) -> ca.Function:
    """O of the pair, as a function of states, inputs and parameters."""
    return observability_matrix(block(unknown, derivatives), outputs, order)


def numbers(b: Block) -> list[float]:
    """The defaults of all parameters."""
    return [parameter.default for parameter in b.parameters.values()]


def evaluate(b: Block, f: ca.Function, point: Point) -> Array:
    return np.array(f([point.get(n, 0.003) for n in b.x], [point[n] for n in b.u], numbers(b)))


def matrix(unknown: str, outputs: tuple[str, ...], order: int, point: Point, derivatives: int = 0) -> Array:
    return evaluate(block(unknown, derivatives), function(unknown, outputs, order, derivatives), point)


def sizes(b: Block) -> dict[str, float]:
    return {name: SIZE.get(name, 0.01) for name in b.x}


def verdict(unknown: str, point: Point, outputs: tuple[str, ...] = SENSORS, order: int = 6) -> Verdict:
    """What these sensors see of the pair at a point."""
    b = block(unknown)
    return judge(matrix(unknown, outputs, order, point), list(b.x), sizes(b), len(outputs))


def simple(dx: Callable[[Symbols], Mapping[str, object]], y: Callable[[Symbols], Mapping[str, object]], names: str):
    x = symbols(names)
    return Block("simple", x=x, dx=Symbols(dx(x)), y=Symbols(y(x)))


def linear(A: Array, C: Array) -> Block:
    """ẋ = A x, y = C x."""
    x = symbols(f"s{i}" for i in range(len(A)))
    dx, y = ca.DM(A) @ x.vector(), ca.DM(C) @ x.vector()
    return Block(
        "linear",
        x=x,
        dx=Symbols({name: dx[i] for i, name in enumerate(x)}),
        y=Symbols({f"y{i}": y[i] for i in range(len(C))}),
    )


def judged(b: Block, order: int, at: Sequence[float], outputs: Sequence[str] = ()) -> Verdict:
    """What the outputs of a small system see, all states of size 1."""
    outputs = outputs or list(b.y)
    f = observability_matrix(b, outputs, order)
    return judge(np.array(f(at, [], numbers(b))), list(b.x), dict.fromkeys(b.x, 1.0), len(outputs))


def kernel_of(v: Verdict) -> Array:
    """The null directions as orthonormal columns."""
    if not v.null_directions:
        return np.zeros((len(v.coordinates), 0))
    return orth(np.array([[d.get(n, 0.0) for n in v.coordinates] for d in v.null_directions]).T)


def same_space(left: Array, right: Array, tolerance: float) -> bool:
    return left.shape == right.shape and bool(np.allclose(left @ left.T, right @ right.T, atol=tolerance))
