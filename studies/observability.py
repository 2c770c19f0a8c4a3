"""Observability of the pair in a scenario: at a point, along the run, over a map; as rank and as accuracy."""

from __future__ import annotations

import functools
import itertools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..codegen.library import Array, Library, compile_functions
from ..codegen.stepper import functions
from ..model.block import Block
from ..model.curves import Curves
from ..model.pair import pair
from ..model.pulses import PULSES
from ..model.symbols import MUSCLES, SIGNALS
from ..observers.observability import (
    TOLERANCE,
    Verdict,
    augmented,
    decoupling_matrix,
    judge,
    observability_matrix,
    ranks_of,
    structural_rank,
)
from .information import deviations
from .prepare import Prepared, prepare
from .quote import shown
from .scenario import Value
from .table import ScenarioError
from .tendon import Tendon, tendon


@dataclass(frozen=True)
class Sensor:
    """What a laboratory can measure: an output of the plant, and the half-width of its noise in the paper."""

    output: str
    noise: float
    sentence: str


SENSORS = {
    "x1": Sensor("x1", 1e-3, "position of the mass"),
    "x2": Sensor("x2", 1e-3, "velocity of the mass"),
    "F1": Sensor("Phi_S1", 1e-3, "force of tendon 1"),
    "F2": Sensor("Phi_S2", 1e-3, "force of tendon 2"),
    "L_C1": Sensor("L_C1", 1e-3, "length of fibre 1"),
    "L_C2": Sensor("L_C2", 1e-3, "length of fibre 2"),
}
PAPER_SENSORS = ("x1", "F1", "F2")

UNKNOWNS = {"none": (), "u": ("Delta", "u1", "u2"), "a": ("Delta", "a1", "a2")}

# `d2u1` is the second derivative of u1
_DERIVATIVE = re.compile(r"^d\d+")

# a step either side of the point, as a part of the typical size, and the change of O that is a kink
_BESIDE, _KINK = 1e-6, 1e-2
# a jump is still there this much nearer, where a steep slope has shrunk
_NEARER = 1e-3


@dataclass(frozen=True, eq=False)
class Question:
    """Which sensors, which unknowns, how many Lie derivatives; `p` are the plant's numbers in a scenario."""

    block: Block
    sensors: tuple[str, ...]
    unknown: str
    order: int
    matrix: ca.Function
    structural_rank: int
    p: tuple[float, ...]
    period: float
    curves: Curves

    @property
    def coordinates(self) -> list[str]:
        """What is to be known: the states, then the unknowns."""
        return list(self.block.x)

    def tendon(self, muscle: str) -> Tendon:
        """The tendon of a muscle."""
        return tendon(self.curves, muscle, dict(zip(self.block.p, self.p, strict=True)))

    @property
    def sizes(self) -> dict[str, float]:
        """The typical size of each coordinate; a derivative's is that of its signal."""
        return {name: SIGNALS[_DERIVATIVE.sub("", name)].size for name in self.coordinates}


@dataclass(frozen=True)
class Answer:
    """What can be known at one point."""

    point: Mapping[str, float]
    verdict: Verdict
    regions: Mapping[str, str]  # of each tendon and fibre
    kinks: Mapping[str, tuple[int, int]]  # coordinates across which O jumps: the rank below and above
    deviations: Mapping[str, float]  # smallest standard deviation within one time unit; inf: none


def observability(
    source: str | Path = "paper-clean",
    place: Mapping[str, float] | None = None,
    sensors: Sequence[str] = PAPER_SENSORS,
    unknown: str = "none",
    order: int | None = None,
    changes: Mapping[str, Value] | None = None,
) -> Answer:
    """What `sensors` determine at a point of a scenario: its start, with the coordinates of `place` instead.

    sensors: of x1, x2, F1, F2, L_C1, L_C2. unknown: "none", "u" (Δ, u1, u2) or "a" (Δ, a1, a2), as constants.
    ScenarioError for a wrong scenario, sensor, coordinate or a point outside the domain.
    """
    prepared = prepare(source, None, changes or {})
    question = ask(prepared, sensors, unknown, order)
    valid = [*question.block.x, *question.block.u]
    if wrong := [name for name in place or {} if name not in valid]:
        raise ScenarioError(f"no coordinate {shown(wrong[0])}; there are {', '.join(valid)}")
    return at(question, start_point(prepared) | dict(place or {}))


def ask(
    prepared: Prepared,
    sensors: Sequence[str] = PAPER_SENSORS,
    unknown: str = "none",
    order: int | None = None,
    derivatives: int = 0,
) -> Question:
    """The question with the scenario's numbers. ScenarioError says what is wrong with it.

    order: highest Lie derivative, n − 1 by default. derivatives: 0 for constant unknowns, else the unknowns are
    signals and their derivatives up to this order are coordinates too.
    """
    if not sensors:
        raise ScenarioError(f"without a sensor nothing can be observed; there are {', '.join(SENSORS)}")
    for name in sensors:
        if name not in SENSORS:
            raise ScenarioError(f"unknown sensor {shown(name)}; there are {', '.join(SENSORS)}")
    if unknown not in UNKNOWNS:
        raise ScenarioError(f"unknown inputs {shown(unknown)}; there are {', '.join(UNKNOWNS)}")
    if not 0 <= derivatives <= _HIGHEST:
        raise ScenarioError(f"the derivatives of the unknowns must be from 0 to {_HIGHEST}, not {derivatives}")
    block = _plant(unknown, prepared.scenario.curves, derivatives)
    order = min(len(block.x) - 1, _HIGHEST) if order is None else order
    if not 0 <= order <= _HIGHEST:
        raise ScenarioError(f"the order of the Lie derivatives must be from 0 to {_HIGHEST}, not {order}")
    outputs = tuple(SENSORS[name].output for name in dict.fromkeys(sensors))
    matrix, rank = _matrix(block, outputs, order)
    period = prepared.value("noise.period") or _PERIOD
    return Question(
        block,
        tuple(dict.fromkeys(sensors)),
        unknown,
        order,
        matrix,
        rank,
        _numbers(block, prepared),
        period,
        prepared.scenario.curves,
    )


# expressions grow by 1.5 to 3 with each order; a rank that has not grown until then does not
_HIGHEST = 10
# where a scenario has no samples
_PERIOD = 0.005


@functools.cache
def _plant(unknown: str, curves: Curves, derivatives: int) -> Block:
    return augmented(pair("given" if unknown == "a" else "virtual", curves), UNKNOWNS[unknown], derivatives)


@functools.cache
def _matrix(block: Block, outputs: tuple[str, ...], order: int) -> tuple[ca.Function, int]:
    return observability_matrix(block, outputs, order), structural_rank(block, outputs, order)


def _numbers(block: Block, prepared: Prepared) -> tuple[float, ...]:
    """The plant's parameters in the order of `block.p`."""
    known = {f"plant.{name}": name for name in block.p} | {name: name for name in block.p}
    values = {known[path]: prepared.value(path) for path in prepared.table.paths if path in known}
    return tuple(values.get(name, block.parameters[name].default) for name in block.p)


def start_point(prepared: Prepared) -> dict[str, float]:
    """The true states and inputs of the scenario at τ = 0."""
    truth, held = prepared.loop.truth, PULSES
    table = functions(truth, held, ())
    p, w = prepared.table.values(truth, prepared.scenario.given), [0.0] * len(held)
    x = table["init"](0, p, w, [])
    outputs = np.array(table["out"](0, x, p, w, [])[0], dtype=float).ravel().tolist()
    return dict(zip(truth.y, outputs, strict=True))


def at(question: Question, point: Mapping[str, float], tolerance: float = TOLERANCE, window: float = 1.0) -> Answer:
    """The answer at a point: values by name for all coordinates and known inputs; `window` for the accuracy.

    ScenarioError outside the domain.
    """
    # the derivatives of unknown signals are 0 unless given
    point = {**dict.fromkeys(question.block.x, 0.0), **point}
    used = {name: point[name] for name in (*question.block.x, *question.block.u)}
    _check_domain(question, used)
    verdict, kinked = _verdict(question, point, tolerance), list(_kinks(question, point))
    if kinked:
        # derivatives at a kink itself belong to neither side: the lowest rank of all corners counts
        corners = (_corner(question, point, kinked, signs) for signs in itertools.product((-1, 1), repeat=len(kinked)))
        verdict = min((_verdict(question, corner, tolerance) for corner in corners), key=lambda corner: corner.rank)
    kinks = {name: _ranks_beside(question, point, name, tolerance) for name in kinked}
    spread = deviations(
        question.block,
        _vectors(question, point),
        question.p,
        {SENSORS[name].output: SENSORS[name].noise for name in question.sensors},
        question.sizes,
        question.period,
        window,
    )
    return Answer(used, verdict, regions(question, point), kinks, spread)


def _verdict(question: Question, point: Mapping[str, float], tolerance: float) -> Verdict:
    x, u = _vectors(question, point)
    matrix = np.array(question.matrix(x, u, question.p), dtype=float)
    return judge(matrix, question.coordinates, question.sizes, len(question.sensors), tolerance)


def matrices(question: Question, points: Mapping[str, Array], progress: Callable[[float], None]) -> Array:
    """O at many points as compiled C: (points × rows × coordinates)."""
    library = _compiled(question.matrix)
    names = [*question.block.x, *question.block.u]
    columns = np.stack(np.broadcast_arrays(*(points[name] for name in names)), axis=1)
    n = len(question.block.x)
    chunks = []
    for begin in range(0, len(columns), _CHUNK):
        rows = columns[begin : begin + _CHUNK]
        (flat,) = library.call("observability", rows[:, :n], rows[:, n:], question.p)
        chunks.append(flat.reshape(len(rows), n, -1).transpose(0, 2, 1))
        progress(min(1.0, (begin + _CHUNK) / len(columns)))
    return np.concatenate(chunks)


_CHUNK = 4000


@functools.cache
def _compiled(matrix: ca.Function) -> Library:
    return compile_functions([matrix])


def rank_and_conditioning(
    question: Question, stack: Array, tolerance: float = TOLERANCE
) -> tuple[NDArray[np.int64], Array]:
    """The rank of each O, and its smallest singular value with columns × typical size and rows as they are.

    The second fades continuously where the first jumps: it is how much the outputs and their derivatives change
    when the worst combination of coordinates changes by its typical size.
    """
    sizes = [question.sizes[name] for name in question.coordinates]
    values = np.linalg.svd(np.nan_to_num(stack * sizes), compute_uv=False)
    return ranks_of(stack, sizes, len(question.sensors), tolerance), np.asarray(values[:, -1])


def determinant(question: Question, points: Mapping[str, Array]) -> Array:
    """|det| of the map from (x, Δ, u) to the fewest output derivatives: Φ′²_S1 Φ′²_S2 for the paper's sensors."""
    outputs = [SENSORS[name].output for name in question.sensors]
    function = decoupling_matrix(question.block, outputs, UNKNOWNS[question.unknown])
    if function.size1_out(0) != function.size2_out(0):
        raise ScenarioError(
            "the determinant needs as many output derivatives as coordinates: x1,F1,F2 with unknown u or a"
        )
    names = [*question.block.x, *question.block.u]
    columns = np.stack(np.broadcast_arrays(*(points[name] for name in names)), axis=1)
    n = len(question.block.x)
    (flat,) = compile_functions([function]).call("decoupling", columns[:, :n], columns[:, n:], question.p)
    return np.asarray(np.abs(np.linalg.det(flat.reshape(len(columns), n, n))))


def force_and_slope(question: Question, muscle: str, lengths: Array) -> tuple[Array, Array]:
    """Φ_S and Φ′_S of a muscle's tendon at the lengths given."""
    own = question.tendon(muscle)
    return own.force(lengths), own.slope(lengths)


def regions(question: Question, point: Mapping[str, float]) -> dict[str, str]:
    """Where each tendon is on its curve, and whether each fibre shortens."""
    outputs = _outputs(question, point)
    result = {}
    for j, muscle in enumerate(MUSCLES, start=1):
        L, (slack, end) = point[f"x{j + 2}"], question.tendon(muscle).edges
        result[f"tendon {j}"] = "slack" if L <= slack else "toe" if L < end else "linear"
        u = outputs[f"u{j}"]
        result[f"fibre {j}"] = "shortening" if u > 0 else "lengthening" if u < 0 else "isometric"
        for limit, words in _LIMITS.items():
            if outputs.get(f"guard.{limit.format(j)}"):
                result[f"fibre {j}"] += f", {words}"
    return result


_LIMITS = {
    "a{}_limit": "its activation at a limit",
    "z{}_limit": "its force factor at a limit: the activation no longer moves it",
    "a{}_infeasible": "asking for an activation outside [0, 1]",
}


def _kinks(question: Question, point: Mapping[str, float]) -> Iterator[str]:
    """Coordinates on whose two sides O differs, however near the sides are: a steep slope shrinks, a jump does not."""
    for name in question.coordinates:
        jumps = []
        for nearer in (1.0, _NEARER):
            below, above = (
                np.array(question.matrix(*_vectors(question, side), question.p), dtype=float)
                for side in (_corner(question, point, [name], [sign], nearer) for sign in (-1, 1))
            )
            largest = np.maximum(np.abs(below).max(axis=1), np.abs(above).max(axis=1))
            jumps.append(np.abs(above - below).max(axis=1) > _KINK * largest)
        if (jumps[0] & jumps[1]).any():
            yield name


def _ranks_beside(question: Question, point: Mapping[str, float], name: str, tolerance: float) -> tuple[int, int]:
    below, above = (_verdict(question, _corner(question, point, [name], [s]), tolerance).rank for s in (-1, 1))
    return below, above


def _corner(
    question: Question, point: Mapping[str, float], names: Sequence[str], signs: Sequence[int], nearer: float = 1.0
) -> dict[str, float]:
    """`point` moved a little to one side in each of the coordinates named."""
    moved = {
        name: point[name] + sign * nearer * _BESIDE * question.sizes[name]
        for name, sign in zip(names, signs, strict=True)
    }
    return {**point, **moved}


def _vectors(question: Question, point: Mapping[str, float]) -> tuple[list[float], list[float]]:
    return [point[name] for name in question.block.x], [point[name] for name in question.block.u]


def _outputs(question: Question, point: Mapping[str, float]) -> dict[str, float]:
    """Outputs, `domain.…` and `guard.…` of the plant at a point."""
    block = question.block
    groups = {"": block.y, "domain.": block.domain, "guard.": block.guards}
    entries = {prefix + name: value for prefix, group in groups.items() for name, value in group.items()}
    function = ca.Function(
        "outputs", [group.vector() for group in (block.x, block.u, block.p)], [ca.vertcat(*entries.values())]
    )
    x, u = _vectors(question, point)
    return dict(zip(entries, np.array(function(x, u, question.p), dtype=float).ravel().tolist(), strict=True))


def _check_domain(question: Question, point: Mapping[str, float]) -> None:
    for name, value in _outputs(question, point).items():
        if name.startswith("domain.") and not value > 0:
            what = "fibre" if "L_C" in name else "tendon"
            raise ScenarioError(
                f"outside the domain: the {what} length {name.removeprefix('domain.')} = {value:g} is not positive"
            )
