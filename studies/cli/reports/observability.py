"""The answer to a question of observability as sentences, a table and JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import xarray as xr
from rich.table import Table
from rich.text import Text

from ....observers.observability import Verdict
from ...observability.point import Answer
from ...observability.question import Question
from .number import counted, number

_SIZES = {
    True: "0.01 for x, Δ, u; 0.5 for a1, 0.1 for a2",
    False: "0.1 for q, dq, Δ, u; 0.01 for L_S, 0.3 for a",
}


def summary(question: Question, answer: Answer) -> str:
    """One sentence: what was asked, and the rank."""
    verdict = answer.verdict
    state = "observable" if verdict.full else f"not observable: {', '.join(verdict.unobservable)}"
    return (
        f"sensors {', '.join(question.sensors)}; {_inputs(question)}{_numbers(question)}: "
        f"rank {verdict.rank} of {len(verdict.coordinates)}, {state} (structural rank {question.structural_rank})"
    )


def _inputs(question: Question) -> str:
    if not question.unknowns:
        return "activations and uncertainty known" if question.numbers else "inputs and uncertainty known"
    if question.system.paper:
        return f"{', '.join(question.unknowns).replace('Delta', 'Δ')} unknown"
    joints, muscles = (", ".join(names) for names in (question.system.joints, question.system.muscles))
    return f"Δ of {joints} and {question.unknown} of {muscles} unknown"


def _numbers(question: Question) -> str:
    return f"; numbers {', '.join(question.numbers)} unknown" if question.numbers else ""


def answer_table(question: Question, answer: Answer) -> Table:
    """Value, verdict and accuracy of each coordinate."""
    table = Table(box=None, padding=(0, 2, 0, 0))
    for head in ("coordinate", "value", "determined", "σ within 1 time unit"):
        table.add_column(head, justify="left" if head == "coordinate" else "right", no_wrap=True)
    for name in question.coordinates:
        lost, deviation = name in answer.verdict.unobservable, answer.deviations[name]
        accuracy = "–" if math.isinf(deviation) else number(deviation)
        known = Text("no", "red") if lost else Text("yes")
        table.add_row(Text(name), f"{answer.point[name]:.6g}", known, accuracy)
    return table


def _scaling(question: Question) -> str:
    sizes = _SIZES[question.system.paper] + "; a tenth of a number" * bool(question.numbers)
    return f"columns × typical size ({sizes}), rows normalised, zero rows stay zero"


def _as_functions(question: Question, lost: Sequence[str]) -> str:
    """Ranks are those of constants, which borrow from the future."""
    unknown, sensors = counted(len(question.unknowns), "unknown"), counted(len(question.sensors), "sensor")
    told = f"not determined {', '.join(lost)}" if lost else "all are determined"
    return f"{unknown} and {sensors}; as functions of time, not constants: {told}"


def details(question: Question, answer: Answer, tolerance: float) -> Iterator[str]:
    """Sentences: order by order, singular values, null directions, regions, kinks."""
    verdict = answer.verdict
    if answer.lost_as_functions is not None:
        yield _as_functions(question, answer.lost_as_functions)
    if question.units:
        yield f"units: {question.units}, angles in rad"
    by_order = ", ".join(map(str, verdict.ranks))
    yield f"rank with Lie derivatives up to order 0, 1, …: {by_order}{_growth(verdict)}"
    yield f"singular values: {', '.join(f'{value:.2g}' for value in verdict.singular_values)}"
    yield f"  ({_scaling(question)}; zero below {tolerance:g} of the largest)"
    for direction in verdict.null_directions:
        yield f"moves without a trace: {_direction(direction)}"
    if question.numbers and verdict.full:
        yield f"moves with the smallest trace: {_direction(verdict.weakest)}"
    yield "; ".join(f"{part}: {words}" for part, words in answer.regions.items())
    for name, (below, above) in answer.kinks.items():
        sides = f"rank {below} below, {above} above" if below != above else f"rank {below} on both sides"
        where = f"{name} = {answer.point[name]:.6g}"
        yield f"warning: the derivatives jump at {where} ({sides}); the lower one is shown"
    if any(math.isnan(deviation) for deviation in answer.deviations.values()):
        yield "σ is unknown: the motion from here is too fast, or grows too large, to be computed"
    later = [name for name in verdict.unobservable if math.isfinite(answer.deviations[name])]
    if later:
        yield f"{', '.join(later)}: not here, but the motion makes it known within 1 time unit"


def answer_as_json(question: Question, answer: Answer, tolerance: float) -> str:
    """Everything for programs; a standard deviation that does not exist is null."""
    verdict = answer.verdict
    content = {
        "rank": verdict.rank,
        "n": len(verdict.coordinates),
        "structural_rank": question.structural_rank,
        "singular_values": verdict.singular_values,
        "unobservable": verdict.unobservable,
        "coordinates": verdict.coordinates,
        "ranks_by_order": verdict.ranks,
        "null_directions": verdict.null_directions,
        "sensors": question.sensors,
        "unknown": question.unknown,
        "parameters": list(question.numbers),
        "weakest": verdict.weakest,
        "order": question.order,
        "tolerance": tolerance,
        "scaling": _scaling(question),
        "point": dict(answer.point),
        "regions": dict(answer.regions),
        "lost_as_functions": None if answer.lost_as_functions is None else list(answer.lost_as_functions),
        "kinks": {name: list(sides) for name, sides in answer.kinks.items()},
        "deviations": {name: value if math.isfinite(value) else None for name, value in answer.deviations.items()},
    }
    return json.dumps(content, indent=2, ensure_ascii=False)


def ranks_along(data: xr.Dataset) -> str:
    """How long each rank lasted along a run: each lasts until the next is known."""
    ranks, time = data["rank"].values, data.time.values
    steps = np.diff(time, append=time[-1])
    return "rank " + ", ".join(f"{rank} for {steps[ranks == rank].sum():.4g}" for rank in np.unique(ranks)[::-1])


def ranks_over(data: xr.Dataset) -> str:
    """How much of a map has which rank."""
    ranks, counts = np.unique(data["rank"].values[data["rank"].values >= 0], return_counts=True)
    shares = zip(ranks[::-1], counts[::-1] / max(1, counts.sum()), strict=True)
    return "rank " + ", ".join(f"{rank} on {share:.0%}" for rank, share in shares)


def _growth(verdict: Verdict) -> str:
    idle = len(verdict.ranks) - 1 - verdict.ranks.index(verdict.rank)
    if idle:
        return f"; it did not grow for {counted(idle, 'more order')}"
    return "" if verdict.full else "; a higher --order may add to it"


def _direction(direction: Mapping[str, float]) -> str:
    if len(direction) == 1:
        return f"{next(iter(direction))} alone"
    return ", ".join(f"{name} {value:+.3g}" for name, value in direction.items()) + " (in typical sizes)"
