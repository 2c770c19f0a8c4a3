"""A model's filter and smoother, compiled, over the samples of a recording."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...codegen.scans import Scans
from ...model.arrays import Array
from ...model.block import symbols
from ...observers.kalman.model import Model
from ...observers.kalman.passes import Passes



@dataclass(frozen=True, eq=False)
class Filtered:
    """Of each sample: x⁻ and P⁻ (n × states, then triangle), innovations ν and variances S (n × 3), what is told."""

    predictions: Array
    nu: Array
    S: Array
    told: Array
    log_likelihood: float


@dataclass(frozen=True, eq=False)
class Smoothed:
    """What is told of each sample (n × names), and the score: for each density ΣTλ², ΣTΛ (densities × 2)."""

    told: Array
    score: Array


class CompiledPasses:
    """Both passes of a model as machine code."""

    def __init__(self, model: Model) -> None:
        passes = Passes(model)
        self.model, self.densities = model, tuple(model.noise(symbols(model.parameters)))
        self._start, self._sizes = passes.start(), passes.sizes
        self._scans = Scans([passes.motion(), passes.forward(), passes.backward()])

    def motions(self, numbers: Mapping[str, float], table: Array) -> Array:
        """The motion from each row to the next; the first row has itself before it."""
        padded = np.concatenate([table[:1], table])
        return self._scans.run("motion", self._values(numbers), [], padded[:-1], padded[1:]).results

    def filtered(self, numbers: Mapping[str, float], table: Array, motions: Array) -> Filtered:
        """The filter over all rows of a table whose columns are those of the model's samples."""
        p, sizes = self._values(numbers), self._sizes
        carry = np.array(self._start(p, table[0]), dtype=float)
        results = self._scans.run("forward", p, carry, motions, table).results
        ends = np.cumsum([sizes.states + sizes.covariance, sizes.measurements, sizes.measurements])
        predictions, nu, S, told = np.split(results, ends, axis=1)
        counted = table[:, -1] * table[:, -2]
        # log L = −½ Σ (log 2πS + ν²/S)
        terms = (np.log(2 * np.pi * S) + nu**2 / S).sum(axis=1)
        return Filtered(predictions, nu, S, told, -0.5 * float(np.sum(terms * counted)))

    def smoothed(self, numbers: Mapping[str, float], table: Array, motions: Array, filtered: Filtered) -> Smoothed:
        """The smoother over the rows that were filtered with the same numbers."""
        sizes = self._sizes
        carry = np.zeros(sizes.states + sizes.covariance + 2 * sizes.densities)
        p = self._values(numbers)
        passed = self._scans.run("backward", p, carry, motions, table, filtered.predictions, backwards=True)
        return Smoothed(passed.results, passed.carry[-2 * sizes.densities :].reshape(sizes.densities, 2))

    def _values(self, numbers: Mapping[str, float]) -> Array:
        return np.array([numbers[name] for name in self.model.parameters], dtype=float)


@functools.cache
def compiled(model: Model) -> CompiledPasses:
    """The passes of a model, compiled once."""
    return CompiledPasses(model)


def table(model: Model, columns: Mapping[str, Array], seen: Array, counted: Array) -> Array:
    """The rows of a recording (n × names) in the order in which the passes take them."""
    return np.column_stack([*(columns[name] for name in model.inputs), seen, counted])
