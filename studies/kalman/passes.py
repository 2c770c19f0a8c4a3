"""A model's filter and smoother, compiled, over the samples of a recording."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...codegen.recordings.scans import Scans
from ...model.arrays import Array
from ...model.block import symbols
from ...observers.kalman.model import Model
from ...observers.kalman.passes import FLAGS, Passes


@dataclass(frozen=True, eq=False)
class Filtered:
    """Of each sample: x⁻ and P⁻ (n × states, then triangle), innovations ν and variances S (n × 3), what is told.

    carry: what goes on to the sample after the last.
    """

    predictions: Array
    nu: Array
    S: Array
    told: Array
    carry: Array

    def followed_by(self, later: Filtered) -> Filtered:
        """The same, and the samples after it."""
        return Filtered(
            np.concatenate([self.predictions, later.predictions]),
            np.concatenate([self.nu, later.nu]),
            np.concatenate([self.S, later.S]),
            np.concatenate([self.told, later.told]),
            later.carry,
        )


@dataclass(frozen=True, eq=False)
class Smoothed:
    """What is told of each sample (n × names), and the score: for each density ΣTλ², ΣTΛ (densities × 2)."""

    told: Array
    score: Array


class CompiledPasses:
    """Both passes of a model as machine code. A table has the columns of `table` below, a row for each sample."""

    def __init__(self, model: Model) -> None:
        passes = Passes(model)
        self.model, self.densities = model, tuple(model.noise(symbols(model.parameters)))
        self.told = passes.told
        self._start, self._sizes = passes.start(), passes.sizes
        self._scans = Scans([passes.motion(), passes.forward(), passes.backward()])

    def start(self, numbers: Mapping[str, float], first: Array) -> Array:
        """What the filter carries to the first row of a table."""
        return np.array(self._start(self._values(numbers), first), dtype=float)

    def motions(self, numbers: Mapping[str, float], table: Array, before: Array | None = None) -> Array:
        """The motion to each row from the one before; the first row has itself before it, or another."""
        padded = np.concatenate([table[:1] if before is None else before[None], table])
        return self._scans.run("motion", self._values(numbers), [], padded[:-1], padded[1:]).results

    def filtered(self, numbers: Mapping[str, float], carry: Array, table: Array, motions: Array) -> Filtered:
        """The filter over all rows of a table."""
        sizes = self._sizes
        passed = self._scans.run("forward", self._values(numbers), carry, motions, table)
        ends = np.cumsum([sizes.states + sizes.covariance, sizes.measurements, sizes.measurements])
        predictions, nu, S, told = np.split(passed.results, ends, axis=1)
        return Filtered(predictions, nu, S, told, passed.carry)

    def smoothed(
        self, numbers: Mapping[str, float], table: Array, motions: Array, filtered: Filtered, lag: int = 0
    ) -> Smoothed:
        """The smoother over rows that were filtered with the same numbers.

        lag: each row is told what so many samples after it know, and no more; 0: all. Only then there is a score.
        """
        sizes = self._sizes
        carry = np.zeros(sizes.states + sizes.covariance + 2 * sizes.densities)
        rows = (motions, table, filtered.predictions)
        passed = self._scans.run("backward", self._values(numbers), carry, *rows, backwards=True, window=lag)
        return Smoothed(passed.results, passed.carry[-2 * sizes.densities :].reshape(sizes.densities, 2))

    def _values(self, numbers: Mapping[str, float]) -> Array:
        return np.array([numbers[name] for name in self.model.parameters], dtype=float)


@functools.cache
def compiled(model: Model) -> CompiledPasses:
    """The passes of a model, compiled once."""
    return CompiledPasses(model)


def row_names(model: Model) -> tuple[str, ...]:
    """What a row of a model's table has."""
    return (*model.inputs, *FLAGS)


def table(model: Model, columns: Mapping[str, Array]) -> Array:
    """The rows of a recording (n × names) in the order in which the passes take them."""
    return np.column_stack([columns[name] for name in row_names(model)])


def log_likelihood(filtered: Filtered, table: Array) -> float:
    """log L of the samples that were seen and count."""
    counted = table[:, -1] * table[:, -2]
    # log L = −½ Σ (log 2πS + ν²/S)
    terms = (np.log(2 * np.pi * filtered.S) + filtered.nu**2 / filtered.S).sum(axis=1)
    return -0.5 * float(np.sum(terms * counted))
