"""What some sensors determine at a point of a scenario: as rank, and as accuracy."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np

from ...codegen.stepper import functions
from ...model.signals.pulses import PULSES
from ...model.symbols import MUSCLES
from ...observers.observability import TOLERANCE, Verdict, judge
from ..files.errors import ScenarioError
from ..files.numbers import number
from ..files.quote import shown, table
from ..scenarios.layers import Value
from ..scenarios.prepare import Prepared, prepare
from .information import deviations
from .question import PAPER_SENSORS, SENSORS, Question, pose

# a step either side of the point, as a part of the typical size, and the change of O that is a kink
_BESIDE, _KINK = 1e-6, 1e-2
# a jump is still there this much nearer, where a steep slope has shrunk
_NEARER = 1e-3
_LIMITS = {
    "a{}_limit": "its activation at a limit",
    "z{}_limit": "its force factor at a limit: the activation no longer moves it",
    "a{}_infeasible": "asking for an activation outside [0, 1]",
}


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
    question = pose(prepared, sensors, unknown, order)
    valid = [*question.block.x, *question.block.u]
    coordinates = {name: number(shown(name), value) for name, value in table("place", place or {}).items()}
    if wrong := [name for name in coordinates if name not in valid]:
        raise ScenarioError(f"no coordinate {shown(wrong[0])}; there are {', '.join(valid)}")
    return answer(question, start_point(prepared) | coordinates)


def start_point(prepared: Prepared) -> dict[str, float]:
    """The true states and inputs of the scenario at τ = 0."""
    truth, held = prepared.loop.truth, PULSES
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
    point = {**dict.fromkeys(question.block.x, 0.0), **point}
    used = {name: point[name] for name in (*question.block.x, *question.block.u)}
    outputs = _outputs(question, used)
    _check_domain(outputs)
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
    return Answer(used, verdict, _regions(question, used, outputs), kinks, spread)


def _verdict(question: Question, point: Mapping[str, float], tolerance: float) -> Verdict:
    x, u = _vectors(question, point)
    matrix = np.array(question.matrix(x, u, question.p), dtype=float)
    return judge(matrix, question.coordinates, question.sizes, len(question.sensors), tolerance)


def _regions(question: Question, point: Mapping[str, float], outputs: Mapping[str, float]) -> dict[str, str]:
    """Where each tendon is on its curve, and whether each fibre shortens."""
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
