"""What a sweep varies: paths with their values, as lists, ranges, or samples of a design."""

from __future__ import annotations

import importlib
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...model.arrays import Array
from ..files.errors import ScenarioError
from ..files.numbers import number, numbers, parse_number, switch, typed_whole, whole
from ..files.quote import shown

DESIGNS = ("latin", "sobol")
KINDS = ("grid", "zip", *DESIGNS)
_SHAPES = ("lin", "log")
# the same command makes the same design
_DESIGN_SEED = 0
# an axis with more values is a mistake
_MOST_VALUES = 1_000_000


@dataclass(frozen=True)
class Range:
    """From `low` to `high`, evenly spaced or evenly in the logarithm; `count` values, or 0 for a design to choose.

    ScenarioError for ends that are no finite numbers, and for a count beyond that of an axis.

    >>> over = {"high_gain.eps_h": hillobs.Range(0.05, 0.4, 4, logarithmic=True)}
    >>> hillobs.sweep("paper-noisy", over, seeds=2).sizes["high_gain.eps_h"]
    4
    """

    low: float
    high: float
    count: int = 0
    logarithmic: bool = False

    def __post_init__(self) -> None:
        checked = {
            "low": number("low of a Range", self.low),
            "high": number("high of a Range", self.high),
            "count": whole("count of a Range", self.count, 0, _MOST_VALUES),
            "logarithmic": switch("logarithmic of a Range", self.logarithmic),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def at(self, share: Array) -> Array:
        """The values at shares of the way, 0 to 1."""
        if not self.logarithmic:
            return self.low + share * (self.high - self.low)
        # the ends exactly, whatever the logarithm rounds
        inside = np.exp(math.log(self.low) + share * (math.log(self.high) - math.log(self.low)))
        return np.where(share == 0, self.low, np.where(share == 1, self.high, inside))


Values = Range | Sequence[float] | ArrayLike


@dataclass(frozen=True)
class Axes:
    """The points of a sweep: how they are made, and the value of each path at each point."""

    kind: str
    paths: tuple[str, ...]
    values: tuple[Array, ...]  # per path: along its own dimension in a grid, else per point

    @property
    def shape(self) -> tuple[int, ...]:
        """Points along each dimension of the result."""
        if self.kind == "grid":
            return tuple(len(values) for values in self.values)
        return (len(self.values[0]),) if self.values else ()

    @property
    def size(self) -> int:
        """How many points there are."""
        return math.prod(self.shape)

    @property
    def varied(self) -> list[str]:
        """The paths with more than one value."""
        return [path for path, values in zip(self.paths, self.values, strict=True) if len(np.unique(values)) > 1]

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Names of these dimensions."""
        return self.paths if self.kind == "grid" else ("point",) * bool(self.values)

    def at(self, points: NDArray[np.int64]) -> Array:
        """(points × paths) values, points counted with the last dimension running fastest."""
        places = (points,) * len(self.values)
        if self.kind == "grid" and self.values:
            places = np.unravel_index(points, self.shape)
        columns = [values[place] for values, place in zip(self.values, places, strict=True)]
        return np.stack(columns, axis=1) if columns else np.empty((len(points), 0))


def axes(over: Mapping[str, Values], kind: str = "grid", samples: int = 0) -> Axes:
    """The Axes of `over`, path → values or Range. ScenarioError says what is wrong with them.

    kind: `grid` for all combinations, `zip` for the i-th value of each, `latin` or `sobol` for `samples` points of a
    Latin hypercube or of Sobol's sequence, in the Ranges given.
    """
    if kind not in KINDS:
        raise ScenarioError(f"unknown kind of sweep {shown(kind)}; there are {', '.join(KINDS)}")
    paths = tuple(over)
    samples = whole("samples", samples, 0)
    if kind in DESIGNS:
        return Axes(kind, paths, _design(over, kind, samples))
    values = tuple(_listed(path, given) for path, given in over.items())
    if kind == "zip" and len({len(v) for v in values}) > 1:
        lengths = ", ".join(f"{path} {len(v)}" for path, v in zip(paths, values, strict=True))
        raise ScenarioError(f"to go together, axes must have equally many values: {lengths}")
    for path, axis in zip(paths, values, strict=True):
        if kind == "grid" and len(set(axis.tolist())) < len(axis):
            raise ScenarioError(f"{path} has a value twice")
    return Axes(kind, paths, values)


def parse_axis(text: str) -> tuple[str, Values]:
    """`PATH=VALUES` as typed: `0.1,0.2`, `lin:LOW:HIGH:COUNT`, `log:LOW:HIGH:COUNT`; without COUNT for a design."""
    path, equals, spelled = text.partition("=")
    if not equals or not path or not spelled:
        raise ScenarioError(f"{shown(text)} is not PATH=VALUES, such as high_gain.eps_h=log:0.02:0.5:25")
    shape, *ends = spelled.split(":")
    if not ends:
        return path, [parse_number(path, value) for value in spelled.split(",")]
    if shape not in _SHAPES or len(ends) not in (2, 3):
        raise ScenarioError(f"{shown(text)}: a range is lin:LOW:HIGH:COUNT or log:LOW:HIGH:COUNT")
    low, high = (parse_number(path, end) for end in ends[:2])
    count = typed_whole(f"{path}: the number of values", ends[2], 1, _MOST_VALUES) if len(ends) == 3 else 0
    return path, Range(low, high, count, shape == "log")


def _listed(path: str, given: Values) -> Array:
    """All values of an axis."""
    if isinstance(given, Range):
        check_range(path, given)
        if given.count < 1:
            raise ScenarioError(f"{path}: the range has no number of values; only a design can do without")
        return given.at(np.linspace(0, 1, given.count))
    return numbers(path, given, _MOST_VALUES)


def check_range(path: str, span: Range) -> None:
    """ScenarioError if the range at `path` is empty, or cannot be logarithmic."""
    low, high = span.low, span.high
    if not math.isfinite(high - low):
        raise ScenarioError(f"{path}: the range from {low:g} to {high:g} is beyond all numbers")
    if span.logarithmic and not (low > 0 and high > 0):
        raise ScenarioError(f"{path}: a logarithmic range needs ends above 0, not {low:g} and {high:g}")
    if not low < high and span.count != 1:
        raise ScenarioError(f"{path}: the range from {low:g} to {high:g} is empty")


def _design(over: Mapping[str, Values], kind: str, samples: int) -> tuple[Array, ...]:
    ranges: list[Range] = []
    for path, given in over.items():
        if not isinstance(given, Range):
            raise ScenarioError(f"{path}: a design needs a range, such as {path}=log:0.02:0.5")
        if given.count:
            raise ScenarioError(f"{path}: a design says itself how many samples; leave out the range's {given.count}")
        check_range(path, given)
        ranges.append(given)
    if not ranges:
        raise ScenarioError("a design needs at least one range to sample")
    if not 1 <= samples <= _MOST_VALUES:
        raise ScenarioError(f"a design has 1 to {_MOST_VALUES:,} samples, not {samples}")
    if kind == "sobol" and samples & (samples - 1):
        raise ScenarioError(f"Sobol's sequence is balanced for powers of two only, not for {samples} samples")
    try:
        # imported here: SciPy is an extra
        qmc = importlib.import_module("scipy.stats.qmc")
    except ImportError as error:
        raise ScenarioError("designs need SciPy: pip install 'hillobs[design]'") from error
    sampler = (qmc.LatinHypercube if kind == "latin" else qmc.Sobol)(len(ranges), seed=_DESIGN_SEED)
    shares = np.asarray(sampler.random(samples), dtype=float)
    return tuple(span.at(column) for span, column in zip(ranges, shares.T, strict=True))


def combinations(axes: Axes, paths: Sequence[str]) -> Iterator[dict[str, float]]:
    """The different sets of values that some of the paths take together."""
    values = [axes.values[axes.paths.index(path)].tolist() for path in paths]
    rows = itertools.product(*values) if axes.kind == "grid" else dict.fromkeys(zip(*values, strict=True))
    yield from (dict(zip(paths, row, strict=True)) for row in rows)
