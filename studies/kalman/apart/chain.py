"""The filter of one joint or one muscle: its numbers by likelihood, and what it tells of a recording."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ....model.arrays import Array
from ....observers.kalman.apart.activations import LAW_MODEL, OF_LAW
from ....observers.kalman.apart.integrators import JOINT_MODEL
from ....observers.kalman.model import Model
from ....observers.kalman.parameters import densities, frequency, least_densities, noise, resolved
from ....observers.observer import Sizes
from ..fit import Fit, fitted
from ..orders import Choice, exact_if_likelier, least_of_law, likeliest_chain, tried
from ..passes import compiled
from ..run import How, ahead, innovation_ratios, over

# of a joint's states and of a muscle's, how many come before the unknown input
_BEFORE_JOINT, _BEFORE_MUSCLE = 2, 1

Told = dict[str, Array]


@dataclass(frozen=True, eq=False)
class Chain:
    """The chain of a joint or a muscle, and the sizes of its recording with samples T apart.

    given: values of all numbers of it and of its second pass; by_hand: those among them that are to stay.
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
        likely = max(densities(self._resolved, self.T, order, order)[density], self._least(order))
        return self._known(self.model, {**noise(self.sizes, self.T), density: likely, name: float(order)})

    def chosen(self, tables: Sequence[Array]) -> Choice:
        """The likeliest of all orders."""
        _, _, name = self._names
        return likeliest_chain(functools.partial(self.likeliest, tables), tried(self.by_hand, name), tables)

    def likeliest(self, tables: Sequence[Array], order: int | None = None) -> Fit:
        """Its numbers with the density for which the rows of the tables are likeliest; of an order as `expected`."""
        numbers, (_, density, name) = self.expected(order), self._names
        free = self._free({density: self._least(round(numbers[name]))})
        return fitted(compiled(self.model), tables, numbers, free)

    def chosen_law(self, tables: Sequence[Array], first: Choice) -> Choice:
        """The same of a muscle's second pass; tables: linear about the `first`."""
        passes, order_of = compiled(LAW_MODEL), "order_a"
        free = self._free(least_of_law(LAW_MODEL.parameters, passes.densities))

        def fitting(order: int) -> Fit:
            return fitted(passes, tables, self._known(LAW_MODEL, {**first.fit.numbers, order_of: float(order)}), free)

        choice = likeliest_chain(fitting, tried(self.by_hand, order_of))
        return exact_if_likelier(passes, tables, choice, free, OF_LAW)

    def frequency(self, numbers: Mapping[str, float]) -> float:
        """How fast it follows with these numbers."""
        sigma, density, order = self._names
        joint = self.model is JOINT_MODEL
        before, noise_of = (_BEFORE_JOINT, numbers[sigma]) if joint else (_BEFORE_MUSCLE, self._resolved.sigma_L)
        return frequency(numbers[density], noise_of, self.T, numbers[order] + before)

    def told(self, rows: Array, how: How, numbers: Mapping[str, float], law: Mapping[str, float] | None = None) -> Told:
        """What it tells of the rows of a table, by name.

        numbers: those of the first pass; law: those of the second, for what that tells of rows of its own.
        """
        model = self.model if law is None else LAW_MODEL
        passes, given = compiled(model), {**self.given, **(numbers if law is None else law)}
        pieces = list(over(passes, given, rows, how, ahead(self.frequency(numbers), self.T)))
        return dict(zip(passes.told, np.concatenate(pieces).T, strict=True))

    def innovations(self, rows: Array, numbers: Mapping[str, float]) -> Array:
        """Of the rows of a table, over their standard deviations (n × 1)."""
        return innovation_ratios(compiled(self.model), {**self.given, **numbers}, rows)

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

    def _free(self, least: Mapping[str, float]) -> dict[str, float]:
        return {name: value for name, value in least.items() if name not in self.by_hand}

    def _known(self, model: Model, found: Mapping[str, float]) -> dict[str, float]:
        numbers = {**self.given, **found, **self.by_hand}
        return {name: numbers[name] for name in model.parameters}
