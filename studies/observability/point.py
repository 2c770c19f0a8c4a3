"""What some sensors determine at a point of a scenario: as rank, and as accuracy."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np

from ...codegen.stepper import functions
from ...model.plant import plant
from ...observers.observability import TOLERANCE, Verdict, judge
from ..files.errors import ScenarioError
from ..files.numbers import number
from ..files.quote import shown, table
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.subject import Subject, subject_of
from ..scenarios.layers import Value
from ..scenarios.prepare import Prepared, prepare
from .information import deviations
from .question import Question, numbers_of, pose, pose_mechanism

# a step either side of the point, as a part of the typical size, and the change of O that is a kink
_BESIDE, _KINK = 1e-6, 1e-2
# a jump is still there this much nearer, where a steep slope has shrunk
_NEARER = 1e-3
# of F_max, in the tendons of a mechanism at rest
_TENSION = 0.2
_LIMITS = {
    "a_limit": "its activation at a limit",
    "z_limit": "its force factor at a limit: the activation no longer moves it",
    "a_infeasible": "asking for an activation outside [0, 1]",
}


@dataclass(frozen=True)
class Answer:
    """What can be known at one point."""

    point: Mapping[str, float]
    verdict: Verdict
    regions: Mapping[str, str]  # of each tendon and fibre
    kinks: Mapping[str, tuple[int, int]]  # coordinates across which O jumps: the rank below and above
    deviations: Mapping[str, float]  # smallest standard deviation within one time unit; inf: none
    lost_as_functions: tuple[str, ...] | None  # where the unknowns change as they like; None if none is unknown


def observability(
    source: str | Path = "paper-clean",
    place: Mapping[str, float] | None = None,
    sensors: Sequence[str] | None = None,
    unknown: str = "none",
    order: int | None = None,
    changes: Mapping[str, Value] | None = None,
    mechanism: str | Path | Mechanism | None = None,
    parameters: Sequence[str] = (),
) -> Answer:
    """What `sensors` determine at a point of a scenario: its start, with the coordinates of `place` instead.

    source: the scenario, as `simulate` takes it.

    place: coordinate → value, dimensionless. sensors: of x1, x2, F1, F2, L_C1, L_C2, by default x1, F1, F2. unknown:
    "none", "u" (Δ, u1, u2) or "a" (Δ, a1, a2), as constants. order: highest Lie derivative. changes: path → value.
    mechanism: instead of a scenario and its changes; its sensors are joints and muscles by name, all of them by
    default, and fibres such as BRA.L_C; the point is at rest in the middle of its ranges, with a fifth of F_max in each
    tendon, angles in rad and all else in the units that `hillobs observability --mechanism` prints.
    parameters: numbers of muscles that are not known either, such as ["muscle1.k"], or ["muscle1"] for all of its.
    ScenarioError for a wrong scenario, sensor, coordinate or a point outside the domain.

    >>> seen = hillobs.observability(place={"x3": 1.99}, unknown="u")  # tendon 1 is slack
    >>> seen.verdict.rank, seen.verdict.unobservable
    (5, ('x3', 'u1'))
    """
    if mechanism is not None:
        if changes:
            raise ScenarioError("changes are for scenarios; a mechanism has the numbers of its file")
        subject = subject_of(mechanism)
        question = pose_mechanism(subject, sensors, unknown, order, parameters=parameters)
        start = rest_point(subject, question)
    else:
        prepared = prepare(source, None, changes or {})
        question, start = pose(prepared, sensors, unknown, order, parameters=parameters), start_point(prepared)
    valid = [*question.block.x, *question.block.u]
    coordinates = {name: number(shown(name), value) for name, value in table("place", place or {}).items()}
    if wrong := [name for name in coordinates if name not in valid]:
        raise ScenarioError(f"no coordinate {shown(wrong[0])}; there are {', '.join(valid)}")
    return answer(question, start | coordinates)


def rest_point(subject: Subject, question: Question) -> dict[str, float]:
    """A mechanism at rest in the middle of the ranges of its joints, with a fifth of F_max in each tendon."""
    system = subject.system
    point = dict.fromkeys((*question.block.x, *question.block.u), 0.0)
    units = subject.scales.coordinates.tolist()
    for joint, bound, unit in zip(system.joints, subject.positions.values(), units, strict=True):
        middle = sum(bound.range) / 2 if bound.range else 0.0
        point[system.name("q", joint)] = middle / unit
    for muscle in system.muscles:
        tendon = question.tendon(muscle)
        force = _TENSION * tendon.numbers["F_max"]
        point[system.name("L_S", muscle)] = float(tendon.length(np.array([force]))[0])
    at_rest = {**point, **dict.fromkeys(system.muscle("u"), 0.0)}
    plain = plant(system)
    function = ca.Function("rest", [plain.x.vector(), plain.u.vector(), plain.p.vector()], [plain.y.vector()])
    numbers = numbers_of(plain, subject.scales.numbers)
    outputs = function([at_rest[name] for name in plain.x], [at_rest.get(name, 0.0) for name in plain.u], numbers)
    told = dict(zip(plain.y, np.array(outputs, dtype=float).ravel().tolist(), strict=True))
    # the activations that hold these forces
    return {**point, **{name: told[name] for name in system.muscle("a") if name in point}}


def start_point(prepared: Prepared) -> dict[str, float]:
    """The true states and inputs of the scenario at τ = 0."""
    truth, held = prepared.loop.truth, prepared.loop.held
    table = functions(truth, held, ())
    p, w = prepared.paths.values(truth, prepared.scenario.given), [0.0] * len(held)
    x = table["init"](0, p, w, [])
    outputs = np.array(table["out"](0, x, p, w, [])[0], dtype=float).ravel().tolist()
    return dict(zip(truth.y, outputs, strict=True))


def answer(question: Question, point: Mapping[str, float], tolerance: float = TOLERANCE, window: float = 1.0) -> Answer:
    """The answer at a point: values by name for all coordinates and known inputs; `window` for the accuracy.

    ScenarioError outside the domain.
    """
    # the derivatives of unknown signals are 0 unless given
    point = {**dict.fromkeys(question.block.x, 0.0), **question.numbers, **point}
    used = {name: point[name] for name in (*question.block.x, *question.block.u)}
    outputs = _outputs(question, used)
    _check_domain(outputs)
    kinked = list(_kinks(question, point))
    # derivatives at a kink itself belong to neither side: the lowest rank of all corners counts
    signs = itertools.product((-1, 1), repeat=len(kinked))
    corners = [_corner(question, point, kinked, sides) for sides in signs] if kinked else [point]
    verdict = min((_verdict(question, corner, tolerance) for corner in corners), key=lambda corner: corner.rank)
    kinks = {name: _ranks_beside(question, point, name, tolerance) for name in kinked}
    spread = deviations(
        question.block,
        _vectors(question, point),
        question.p,
        {question.available[name].output: question.available[name].noise for name in question.sensors},
        question.sizes,
        question.period,
        window,
    )
    lost = _lost_as_functions(question, corners, tolerance) if question.unknowns else None
    return Answer(used, verdict, _regions(question, used, outputs), kinks, spread, lost)


def _lost_as_functions(question: Question, corners: Sequence[Mapping[str, float]], tolerance: float) -> tuple[str, ...]:
    """The coordinates that cannot be told at all corners where the unknowns change as they like.

    A constant is told by what its effect becomes later; a function of time only by its effect now.
    """
    free = question.with_functions()
    still = dict.fromkeys(free.block.x, 0.0)
    lost = {name for corner in corners for name in _verdict(free, {**still, **corner}, tolerance).unobservable}
    return tuple(name for name in question.coordinates if name in lost)


def _verdict(question: Question, point: Mapping[str, float], tolerance: float) -> Verdict:
    x, u = _vectors(question, point)
    matrix = np.array(question.matrix(x, u, question.p), dtype=float)
    return judge(matrix, question.coordinates, question.sizes, len(question.sensors), tolerance)


def _regions(question: Question, point: Mapping[str, float], outputs: Mapping[str, float]) -> dict[str, str]:
    """Where each tendon is on its curve, and whether each fibre shortens."""
    result = {}
    system = question.system
    for j, muscle in enumerate(system.muscles, start=1):
        called = j if system.paper else muscle
        L, (slack, end) = point[system.name("L_S", muscle)], question.tendon(muscle).edges
        result[f"tendon {called}"] = "slack" if L <= slack else "toe" if L < end else "linear"
        u = outputs[system.name("u", muscle)]
        result[f"fibre {called}"] = "shortening" if u > 0 else "lengthening" if u < 0 else "isometric"
        for limit, words in _LIMITS.items():
            if outputs.get(f"guard.{system.name(limit, muscle)}"):
                result[f"fibre {called}"] += f", {words}"
    return result


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


def _check_domain(outputs: Mapping[str, float]) -> None:
    for name, value in outputs.items():
        if name.startswith("domain.") and not value > 0:
            what = "fibre" if "L_C" in name else "tendon"
            raise ScenarioError(
                f"outside the domain: the {what} length {name.removeprefix('domain.')} = {value:g} is not positive"
            )
