"""Observability at many points: along the run of a scenario, and over a map of two coordinates."""

from __future__ import annotations

import dataclasses
import json
import warnings
from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...model.arrays import Array
from ...model.symbols import MUSCLES, SIGNALS
from ...observers.observability import TOLERANCE
from ..files.errors import ScenarioError
from ..files.progress import Progress, unseen
from ..files.quote import shown
from ..scenarios.prepare import Prepared
from ..simulate.run import RunWarning, simulate_prepared
from .many import determinant, matrices, rank_and_conditioning
from .question import PAPER_SENSORS, Question

# `tension` moves both tendons to the same force
TENSION = "tension"
MAP_POINTS = 200


def along(
    prepared: Prepared, question: Question, tolerance: float = TOLERANCE, progress: Progress = unseen
) -> xr.Dataset:
    """Rank and conditioning at every recorded point of the scenario's run, with `taut` per muscle.

    ScenarioError if the plant fails on the way.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)
        run = simulate_prepared(dataclasses.replace(prepared, chosen={}))
    if failures := json.loads(run.attrs["failures"]):
        raise ScenarioError(f"there is no run to look along: {next(iter(failures.values()))}")
    points = {state: run.x.sel(state=state).values for state in run.state.values.tolist()}
    points |= {f"{name}{j}": run[name].sel(muscle=j).values for name in ("u", "a") for j in (1, 2)}
    stack = matrices(question, {**points, "Delta": run.Delta.values}, progress)
    rank, conditioning = rank_and_conditioning(question, stack, tolerance)
    data = {"rank": ("time", rank), "conditioning": ("time", conditioning)}
    return _described(question, xr.Dataset(data, {"time": run.time}).assign(taut=run.taut), tolerance)


def over(
    question: Question,
    axes: Sequence[str],
    point: Mapping[str, float],
    points: int = MAP_POINTS,
    tolerance: float = TOLERANCE,
    progress: Progress = unseen,
) -> xr.Dataset:
    """Rank and conditioning over two coordinates, the others as in `point`; NaN and −1 outside the domain.

    With as many output derivatives as coordinates also `determinant`. ScenarioError for axes that do not exist.
    """
    ranges = {axis: np.linspace(*limits, points) for axis, limits in axis_ranges(question, axes, point).items()}
    mesh = dict(zip(axes, np.meshgrid(*ranges.values(), indexing="ij"), strict=True))
    columns = {name: np.full(points**2, value) for name, value in point.items()}
    for axis, values in mesh.items():
        columns |= _placed(question, axis, values.ravel())
    rank, conditioning = rank_and_conditioning(question, matrices(question, columns, progress), tolerance)
    inside = _inside(question, columns)
    shape, dims = (points, points), list(axes)
    data = {
        "rank": (dims, np.where(inside, rank, -1).reshape(shape)),
        "conditioning": (dims, np.where(inside, conditioning, np.nan).reshape(shape)),
    }
    if question.unknown != "none" and question.sensors == PAPER_SENSORS:
        data["determinant"] = (dims, np.where(inside, determinant(question, columns), np.nan).reshape(shape))
    return _described(question, xr.Dataset(data, ranges), tolerance)


def axis_ranges(question: Question, axes: Sequence[str], point: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """The two axes of a map and where they begin and end. ScenarioError if they are not two, or not there."""
    if len(axes) != 2 or axes[0] == axes[1]:
        raise ScenarioError(f"a map has two different axes, such as x3,x4 or x1,{TENSION}, not {shown(','.join(axes))}")
    return {axis: _range(question, axis, point) for axis in axes}


def _range(question: Question, axis: str, point: Mapping[str, float]) -> tuple[float, float]:
    p = dict(zip(question.block.p, question.p, strict=True))
    if axis == TENSION:
        # slack at first: no force belongs to a single length there
        toe = min(question.tendon(muscle).toe_force for muscle in MUSCLES)
        return -0.1 * toe, 1.2 * toe
    if axis not in (*question.block.x, *question.block.u):
        valid = [*question.block.x, *question.block.u, TENSION]
        raise ScenarioError(f"unknown axis {shown(axis)}; there are {', '.join(valid)}")
    if axis in ("x3", "x4"):
        slack, end = question.tendon(MUSCLES[int(axis[1]) - 3]).edges
        return slack - (end - slack) / 2, end + (end - slack) / 2
    if axis == "x1":
        return p["C"] / 2 - 0.3, p["C"] / 2 + 0.3
    if axis.startswith("a"):
        return p["a_min"], 1.0
    size = 20 * SIGNALS[axis].size
    return point[axis] - size, point[axis] + size


def _placed(question: Question, axis: str, values: Array) -> dict[str, Array]:
    """The coordinates that an axis sets."""
    if axis != TENSION:
        return {axis: values}
    lengths = {}
    for j, muscle in enumerate(MUSCLES, start=3):
        slack, end = question.tendon(muscle).edges
        # a force of 0 is any slack length; half a toe below the edge stands for it
        lengths[f"x{j}"] = np.where(values > 0, question.tendon(muscle).length(values), slack - (end - slack) / 2)
    return lengths


def _inside(question: Question, columns: Mapping[str, Array]) -> NDArray[np.bool_]:
    """Whether each point (name → (points)) is in the domain of the plant."""
    block = question.block
    domain = ca.Function(
        "domain", [block.x.vector(), block.u.vector(), block.p.vector()], [ca.mmin(block.domain.vector())]
    )
    x = ca.DM(np.stack([columns[name] for name in block.x]))
    n = x.shape[1]
    u = ca.DM(np.stack([columns[name] for name in block.u])) if block.u else ca.DM(0, n)
    return np.array(domain.map(n)(x, u, ca.repmat(ca.DM(question.p), 1, n)), dtype=float).ravel() > 0


def _described(question: Question, data: xr.Dataset, tolerance: float) -> xr.Dataset:
    about = {
        "rank": "number of coordinates that the outputs determine",
        "conditioning": "smallest singular value of O with columns × typical size",
        "determinant": "|det| of the map to the fewest output derivatives",
        "taut": "1 while the tendon carries force",
    }
    for name, sentence in about.items():
        if name in data:
            data[name].attrs.update(long_name=sentence, units="1")
    data.attrs.update(
        sensors=",".join(question.sensors),
        unknown=question.unknown,
        order=question.order,
        estimated=",".join(question.coordinates),
        tolerance=tolerance,
    )
    return data
