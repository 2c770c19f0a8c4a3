"""An observability question as asked on a command line, and its answer as sentences, a table, JSON and files."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from rich.table import Table
from rich.text import Text

from ....observers.observability import TOLERANCE
from ...files.errors import ScenarioError
from ...files.netcdf import save_netcdf
from ...files.numbers import parse_number
from ...files.progress import Progress
from ...files.quote import shown
from ...observability.point import Answer, at, start_point
from ...observability.question import Question, ask
from ...scenarios.prepare import Prepared, prepare
from ...scenarios.scenario import Value
from .number import number

SCALING = "columns × typical size (0.01 for x, Δ, u; 0.5 for a1, 0.1 for a2), rows normalised, zero rows stay zero"
_INPUTS = {
    "none": "inputs and uncertainty known",
    "u": "Δ, u1, u2 unknown",
    "a": "Δ, a1, a2 unknown",
}

# with Lie derivatives up to 2 every unknown constant has appeared in the paper's outputs
_LEAST = 2

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Asked:
    """A question with its answer, and how it can be shown."""

    prepared: Prepared
    question: Question
    answer: Answer
    tolerance: float
    many: Question  # the same with the order that maps and runs use

    def summary(self) -> str:
        """One sentence: what was asked, and the rank."""
        verdict, question = self.answer.verdict, self.question
        state = "observable" if verdict.full else f"not observable: {', '.join(verdict.unobservable)}"
        return (
            f"sensors {', '.join(question.sensors)}; {_INPUTS[question.unknown]}: "
            f"rank {verdict.rank} of {len(verdict.coordinates)}, {state} (structural rank {question.structural_rank})"
        )

    def table(self) -> Table:
        """Value, verdict and accuracy of each coordinate."""
        table = Table(box=None, padding=(0, 2, 0, 0))
        for head in ("coordinate", "value", "determined", "σ within 1 time unit"):
            table.add_column(head, justify="left" if head == "coordinate" else "right", no_wrap=True)
        for name in self.question.coordinates:
            lost, deviation = name in self.answer.verdict.unobservable, self.answer.deviations[name]
            shown = "–" if math.isinf(deviation) else number(deviation)
            known = Text("no", "red") if lost else Text("yes")
            table.add_row(Text(name), f"{self.answer.point[name]:.6g}", known, shown)
        return table

    def details(self) -> Iterator[str]:
        """Sentences: order by order, singular values, null directions, regions, kinks."""
        verdict, answer = self.answer.verdict, self.answer
        by_order = ", ".join(map(str, verdict.ranks))
        yield f"rank with Lie derivatives up to order 0, 1, …: {by_order}{_growth(verdict.ranks)}"
        yield f"singular values: {', '.join(f'{value:.2g}' for value in verdict.singular_values)}"
        yield f"  ({SCALING}; zero below {self.tolerance:g} of the largest)"
        for direction in verdict.null_directions:
            yield f"moves without a trace: {_direction(direction)}"
        yield "; ".join(f"{part}: {words}" for part, words in answer.regions.items())
        for name, (below, above) in answer.kinks.items():
            sides = f"rank {below} below, {above} above" if below != above else f"rank {below} on both sides"
            where = f"{name} = {answer.point[name]:.6g}"
            yield f"warning: the derivatives jump at {where} ({sides}); the lower one is shown"
        later = [name for name in verdict.unobservable if math.isfinite(answer.deviations[name])]
        if later:
            yield f"{', '.join(later)}: not here, but the motion makes it known within 1 time unit"

    def json(self) -> str:
        """Everything for programs; a standard deviation that does not exist is null."""
        verdict, question, answer = self.answer.verdict, self.question, self.answer
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
            "order": question.order,
            "tolerance": self.tolerance,
            "scaling": SCALING,
            "point": dict(answer.point),
            "regions": dict(answer.regions),
            "kinks": {name: list(sides) for name, sides in answer.kinks.items()},
            "deviations": {name: value if math.isfinite(value) else None for name, value in answer.deviations.items()},
        }
        return json.dumps(content, indent=2, ensure_ascii=False)


def answer_question(
    source: str,
    changes: Mapping[str, Value],
    place: str | None,
    sensors: str,
    unknown: str,
    order: str | None,
    tolerance: str | None,
    signals: str = "0",
) -> Asked:
    """The question in the words of a command line, answered. ScenarioError names the wrong word."""
    prepared = prepare(source, None, changes)
    names = [name.strip() for name in sensors.split(",") if name.strip()]
    highest = None if order is None else _whole("--order", order)
    question = ask(prepared, names, unknown, highest, _whole("--signals", signals))
    point = start_point(prepared) | _place(place or "", question)
    limit = TOLERANCE if tolerance is None else parse_number("--tolerance", tolerance)
    if not 0 < limit < 1:
        raise ScenarioError(f"--tolerance must be between 0 and 1, not {limit:g}")
    answer, many = at(question, point, limit), question
    if highest is None:
        # orders beyond those that add rank at the point would only cost the compiler time
        enough = max(_LEAST, answer.verdict.ranks.index(answer.verdict.rank))
        many = ask(prepared, names, unknown, min(enough, question.order), _whole("--signals", signals))
    return Asked(prepared, question, answer, limit, many)


def check_axes(asked: Asked, axes: str) -> None:
    """ScenarioError if `axes` are not two that a map can have."""
    from ...observability.map import axis_ranges

    axis_ranges(asked.question, axes.split(","), asked.answer.point)


def write_along(asked: Asked, folder: Path, _: str, progress: Progress) -> tuple[str, list[Path]]:
    """Rank along the run: how long which rank lasted, and the paths of NetCDF and figure."""
    from ...figures.observability import along_figure
    from ...observability.map import along

    data = along(asked.prepared, asked.many, asked.tolerance, progress)
    ranks, counts = np.unique(data["rank"], return_counts=True)
    spacing = float(data.time[1] - data.time[0]) if data.time.size > 1 else 0.0
    lasted = ", ".join(
        f"{rank} for {count * spacing:.4g}" for rank, count in zip(ranks[::-1], counts[::-1], strict=True)
    )
    stem = f"{asked.prepared.scenario.name}-observability"
    return f"along the run, rank {lasted}", _write(data, {"along": along_figure(data)}, folder, stem, "along")


def write_map(asked: Asked, folder: Path, axes: str, progress: Progress) -> tuple[str, list[Path]]:
    """Rank over two coordinates: how much of the map has which rank, and the paths of NetCDF and figure."""
    from ...figures.observability import map_figure
    from ...observability.map import over

    names = axes.split(",")
    data = over(asked.many, names, asked.answer.point, tolerance=asked.tolerance, progress=progress)
    figure = {f"map-{'-'.join(names)}": map_figure(data, asked.many)}
    ranks, counts = np.unique(data["rank"].values[data["rank"].values >= 0], return_counts=True)
    shares = zip(ranks[::-1], counts[::-1] / max(1, counts.sum()), strict=True)
    covered = ", ".join(f"{rank} on {share:.0%}" for rank, share in shares)
    stem = f"{asked.prepared.scenario.name}-observability"
    return f"over the map, rank {covered}", _write(data, figure, folder, stem, f"map-{'-'.join(names)}")


def _write(data: xr.Dataset, drawn: Mapping[str, Figure], folder: Path, stem: str, key: str) -> list[Path]:
    from ...figures.page import write_figures

    path = folder / f"{stem}-{key}.nc"
    save_netcdf(data, path)
    return [path, *write_figures(drawn, folder, stem)]


def _place(text: str, question: Question) -> dict[str, float]:
    """`x1=2.7,x3=2.01` as numbers by name."""
    valid = [*question.block.x, *question.block.u]
    result = {}
    for part in (part.strip() for part in text.split(",") if part.strip()):
        name, equals, value = part.partition("=")
        if name in result:
            raise ScenarioError(f"--at gives {name} twice")
        if not equals or name not in valid:
            raise ScenarioError(f"--at takes NAME=VALUE with the names {', '.join(valid)}, not {shown(part)}")
        result[name] = parse_number(f"--at {name}", value)
    return result


def _whole(what: str, text: str) -> int:
    if not re.fullmatch(r"[+-]?\d{1,6}", text, re.ASCII):
        raise ScenarioError(f"{what} must be a whole number, not {shown(text)}")
    return int(text)


def _growth(ranks: tuple[int, ...]) -> str:
    idle = len(ranks) - 1 - ranks.index(ranks[-1])
    return f"; it did not grow for {idle} more order{'s' if idle > 1 else ''}" if idle else ""


def _direction(direction: Mapping[str, float]) -> str:
    if len(direction) == 1:
        return f"{next(iter(direction))} alone"
    return ", ".join(f"{name} {value:+.3g}" for name, value in direction.items()) + " (in typical sizes)"
