"""A fit of path lengths by OpenSim's PolynomialPathFitter, and how far it is from the geometry."""

from __future__ import annotations

import importlib.util
import itertools
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np

from ....model.arrays import Array
from ....model.skeleton.paths import moment_arms
from ...files.errors import ScenarioError
from ...files.quote import short
from ..mechanisms.paths import path_over
from ..opensim.model import FitRequest
from ..opensim.paths import Polynomial, read_paths
from . import in_opensim

EXTRA = "opensim"
LEAST_ORDER, MOST_ORDER = 2, 9
# points that are fitted: a grid where there are one or two coordinates, else drawn
_ON_LINE, _PER_SIDE, _DRAWN = 201, 31, 2000
# where the fit is tried, beside the corners of the ranges
_TRIED, _SEED = 1000, 1
# rad or m: steps of a line along a coordinate, for a jump may be there and back in 0.08°; and so many at most
_STEP, _MOST_STEPS = 0.0007, 10_000
# m: what a length may bend by in a step, and how many steps apart jumps are others
_BEND, _APART = 2e-4, 50
# where the other coordinates are meanwhile, in parts of their ranges
_STAYS = (0.25, 0.5, 0.75)


@dataclass(frozen=True)
class Jump:
    """Where a muscle's length jumps in OpenSim, by so many m."""

    coordinate: str
    at: float
    size: float


@dataclass(frozen=True)
class PathFit:
    """How far a polynomial is from the geometry, root mean square and largest: lengths and moment arms, in m."""

    muscle: str
    length: tuple[float, float]
    arms: Mapping[str, tuple[float, float]]
    jumps: tuple[Jump, ...]


@dataclass(frozen=True)
class Fitted:
    """Polynomials by muscle, how good they are, and how many of the points OpenSim has used."""

    polynomials: Mapping[str, Polynomial]
    fits: tuple[PathFit, ...]
    used: int
    points: int


def fit(request: FitRequest, order: int) -> Fitted:
    """Fit polynomials of this order over the ranges. ScenarioError if OpenSim is not there, or does not do it."""
    if importlib.util.find_spec(EXTRA) is None:
        raise ScenarioError(f"--fit needs OpenSim, which is not installed: pip install 'hillobs[{EXTRA}]'")
    if not request.ranges:
        raise ScenarioError("no coordinate is free: there is nothing over which to fit")
    names = list(request.ranges)
    ranges = [_range(name, limits) for name, limits in request.ranges.items()]
    random = np.random.default_rng(_SEED)
    low, high = np.array(ranges).T
    corners = np.array(list(itertools.islice(itertools.product(*ranges), _TRIED)))
    check = np.vstack([corners, random.uniform(low, high, (_TRIED, len(names)))])
    lines = [_line(ranges, moving, part) for moving in range(len(names)) for part in _STAYS]
    with tempfile.TemporaryDirectory(prefix="hillobs-fit-") as folder:
        moving = np.repeat(np.repeat(range(len(names)), len(_STAYS)), [len(line) for line in lines])
        points = {"fit": _rows(ranges, random), "check": check, "lines": np.vstack(lines), "moving": moving}
        answer = _ask(Path(folder), request, order, points)
        polynomials = {
            name: path for name, path in read_paths(Path(folder, "paths.xml")).items() if name in request.muscles
        }
        if missing := [name for name in request.muscles if name not in polynomials]:
            raise ScenarioError(f"OpenSim has fitted no path of {', '.join(missing)}: no free coordinate moves it")
        with np.load(Path(folder, "samples.npz")) as samples:
            lengths, arms, along = samples["lengths"], samples["arms"], samples["lines"]
    ends = np.cumsum([len(line) for line in lines])[:-1]
    fits = []
    for number, muscle in enumerate(request.muscles):
        length, arm = _values(polynomials[muscle], names, check)
        crossed = [at for at, name in enumerate(names) if name in polynomials[muscle].coordinates]
        jumps = [
            jump
            for place, (line, values) in enumerate(zip(lines, np.split(along[:, number], ends), strict=True))
            for jump in _jumps(names, place // len(_STAYS), line, values)
        ]
        fits.append(
            PathFit(
                muscle,
                _errors(length - lengths[:, number]),
                {names[at]: _errors(arm[:, at] - arms[:, number, at]) for at in crossed},
                _apart(jumps),
            )
        )
    return Fitted(polynomials, tuple(fits), answer["used"], len(points["fit"]))


def _ask(folder: Path, request: FitRequest, order: int, points: Mapping[str, Array]) -> dict[str, int]:
    """What OpenSim has done in its folder. ScenarioError if it has not."""
    asked = {
        "model": str(request.model.resolve()),
        "muscles": list(request.muscles),
        "columns": [f"/jointset/{request.joints[name]}/{name}" for name in request.ranges],
        "welded": list(request.welded),
        "values": dict(request.held),
        "order": order,
    }
    (folder / "request.json").write_text(json.dumps(asked), encoding="utf-8")
    with (folder / "points.npz").open("wb") as file:
        np.savez(file, allow_pickle=False, **points)
    # by its path, so that it finds no module of ours
    command = [sys.executable, "-P", str(Path(in_opensim.__file__).resolve())]
    done = subprocess.run(
        command,
        cwd=folder,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        check=False,
    )
    try:
        answer: dict[str, int] = json.loads((folder / "answer.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        last = done.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        raise ScenarioError(f"OpenSim ended with code {done.returncode} before it had fitted: {short(last)}") from error
    if "error" in answer:
        raise ScenarioError(f"OpenSim has not fitted: {short(str(answer['error']))}")
    return answer


def _range(name: str, limits: tuple[float, float] | None) -> tuple[float, float]:
    if limits is None:
        raise ScenarioError(f"{name} has no range over which to fit; give one with --range {name}=LOW:HIGH")
    return limits


def _rows(ranges: Sequence[tuple[float, float]], random: np.random.Generator) -> Array:
    """Where OpenSim takes its samples (rows × coordinates)."""
    wide = [low < high for low, high in ranges]
    count = {1: _ON_LINE, 2: _PER_SIDE}.get(sum(wide))
    if count is None:
        low, high = np.array(ranges).T
        return random.uniform(low, high, (_DRAWN, len(ranges)))
    sides = [np.linspace(*limits, count if varies else 1) for limits, varies in zip(ranges, wide, strict=True)]
    return np.array(list(itertools.product(*sides)))


def _line(ranges: Sequence[tuple[float, float]], moving: int, part: float) -> Array:
    """Along a coordinate, where the others stay at this part of their ranges (points × coordinates)."""
    low, high = ranges[moving]
    line = np.linspace(low, high, 1 + min(_MOST_STEPS, int(np.ceil((high - low) / _STEP))))
    points = np.tile([a + part * (b - a) for a, b in ranges], (len(line), 1))
    points[:, moving] = line
    return points


def _values(path: Polynomial, names: Sequence[str], points: Array) -> tuple[Array, Array]:
    """Length (points) and moment arms (points × coordinates) of a polynomial."""
    q = ca.SX.sym("q", len(names))
    by_name = dict(zip(names, ca.vertsplit(q), strict=True))
    length = path_over("a muscle", path, {name: name for name in names}, {}).length(by_name)
    values = ca.Function("path", [q], [length, moment_arms(length, q)]).map(len(points))(points.T)
    return np.array(values[0])[0], np.array(values[1]).reshape(len(names), -1, order="F").T


def _errors(difference: Array) -> tuple[float, float]:
    return float(np.sqrt(np.mean(difference**2))), float(np.abs(difference).max())


def _jumps(names: Sequence[str], moving: int, line: Array, lengths: Array) -> list[Jump]:
    """Where a length bends by more in a step than a muscle can: the largest of each place."""
    bent = np.flatnonzero(np.abs(np.diff(lengths, 2)) > _BEND)
    places = np.split(bent, np.flatnonzero(np.diff(bent) > 2) + 1) if len(bent) else []
    steps = np.abs(np.diff(lengths))
    found = []
    for place in places:
        at = int(place[0] + np.argmax(steps[place[0] : place[-1] + 2]))
        found.append(Jump(names[moving], float(line[at : at + 2, moving].mean()), float(steps[at])))
    return found


def _apart(jumps: Sequence[Jump]) -> tuple[Jump, ...]:
    """The largest of each place, whatever the other coordinates are."""
    kept: list[Jump] = []
    for jump in sorted(jumps, key=lambda jump: -jump.size):
        if all(jump.coordinate != other.coordinate or abs(jump.at - other.at) > _APART * _STEP for other in kept):
            kept.append(jump)
    return tuple(kept)
