"""The filter of one joint or one muscle: its numbers by likelihood, and what it tells of a recording."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ....model.arrays import Array
from ....observers.kalman.apart.integrators import JOINT_MODEL
from ....observers.kalman.model import Model
from ....observers.kalman.parameters import densities, frequency, least_densities, noise, resolved
from ....observers.observer import Sizes
from ..fit import Fit, fitted
from ..orders import Choice, likeliest_chain, tried
from ..passes import compiled
from ..run import How, ahead, over

# of a joint's states and of a muscle's, how many come before the unknown input
_BEFORE_JOINT, _BEFORE_MUSCLE = 2, 1


@dataclass(frozen=True, eq=False)
class Chain:
    """The chain of a joint or a muscle and the sizes of its recording, T apart.

    given: values of all its numbers; by_hand: those among them that are to stay.
    """

    model: Model
    sizes: Sizes
    T: float
    given: Mapping[str, float]
    by_hand: Mapping[str, float]

    def expected(self, order: int | None = None) -> dict[str, float]:
        """Its numbers, with the density that the sizes let expect; of the usual order, unless it is told or given."""
        _, density, name = self._names
        order = tried(self.by_hand, name)[0] if order is None else order
        expected = max(densities(self._resolved, self.T, order, order)[density], self._least(order))
        found = {**self.given, **noise(self.sizes, self.T), density: expected, name: float(order), **self.by_hand}
        return {number: found[number] for number in self.model.parameters}

    def chosen(self, tables: Sequence[Array]) -> Choice:
        """Order and density for which the rows of the tables are likeliest."""
        passes, (_, density, name) = compiled(self.model), self._names

        def fitting(order: int) -> Fit:
            free = {} if density in self.by_hand else {density: self._least(order)}
            return fitted(passes, tables, self.expected(order), free)

        return likeliest_chain(fitting, tried(self.by_hand, name), tables)

    def frequency(self, numbers: Mapping[str, float]) -> float:
        """How fast it follows with these numbers."""
        sigma, density, order = self._names
        before, noise_of = (_BEFORE_JOINT, numbers[sigma]) if self._joint else (_BEFORE_MUSCLE, self._resolved.sigma_L)
        return frequency(numbers[density], noise_of, self.T, numbers[order] + before)

    def told(self, numbers: Mapping[str, float], rows: Array, how: How) -> Iterator[dict[str, Array]]:
        """What it tells of the rows of a table by name, piece by piece."""
        passes = compiled(self.model)
        for piece in over(passes, numbers, rows, how, ahead(self.frequency(numbers), self.T)):
            yield dict(zip(passes.told, piece.T, strict=True))

    @property
    def _joint(self) -> bool:
        return self.model is JOINT_MODEL

    @property
    def _names(self) -> tuple[str, str, str]:
        """What its noise, its √density and its order are called."""
        sigma, density, order, *_ = self.model.parameters
        return sigma, density, order

    @property
    def _resolved(self) -> Sizes:
        return resolved(self.sizes, self.T)

    def _least(self, order: int) -> float:
        _, density, _ = self._names
        return least_densities(self._resolved, self.T, order, order)[density]


def all_of(pieces: Iterator[dict[str, Array]]) -> dict[str, Array]:
    """What is told of all rows."""
    parts = list(pieces)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
