"""Orders, densities and the form of the Kalman filter for a recording, by the likelihood of what was measured."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ...model.arrays import Array
from ...model.block import Parameters
from ...observers.kalman.activations import ACTIVATIONS_MODEL, OF_LAW
from ...observers.kalman.activations import DENSITIES as OF_ACTIVATIONS
from ...observers.kalman.inputs import DENSITIES as OF_INPUTS
from ...observers.kalman.inputs import INPUTS_MODEL
from ...observers.kalman.parameters import densities, least_densities, noise, resolved
from ..files.progress import Progress, shares, unseen
from .fit import Fit, fitted
from .passes import CompiledPasses, compiled
from .record import Record

# another order must be likelier by more than chance makes it; in the first pass a lower one by this much of each
# sample, since the likelihood looks one sample ahead only, where a rougher input is hardly worse
_GAIN, _ROUGHER = 3.0, 0.05
_USUAL, _OTHERS = 2, (1, 3)
# the least of the second pass's densities, in what they are at first: where they mean nothing
_LEAST = 1e-4

# what the second pass alone has
SECOND_PASS: Parameters = {
    name: parameter for name, parameter in ACTIVATIONS_MODEL.parameters.items() if name not in INPUTS_MODEL.parameters
}
# how the names of noise, densities and orders begin
_FOUND = ("s_", "sigma", "order")

# order of Δ, order of u or a → fit
Fitting = Callable[[int, int], Fit]
# that of each chain
Orders = tuple[int, ...]


@dataclass(frozen=True)
class Choice:
    """The likeliest fit, its orders, and log L of all orders that were tried; needed: by how much it must be larger."""

    orders: Orders
    fit: Fit
    tried: Mapping[Orders, float] = field(default_factory=dict)
    needed: Mapping[Orders, float] = field(default_factory=dict)

    @property
    def jumps(self) -> bool:
        """Whether an input of order 1, which jumps, is taken or nearly as likely."""
        rough = tuple(1 for _ in self.orders)
        loss = self.fit.log_likelihood - self.tried.get(rough, -math.inf)
        return self.orders == rough or loss < self.needed.get(rough, 0.0)


def chosen_inputs(
    record: Record, tables: Sequence[Array], by_hand: Mapping[str, float], progress: Progress = unseen
) -> Choice:
    """The model of the first pass for a recording, of which densities are fitted to the `tables`.

    by_hand: name → value of what is to stay as it is.
    """
    passes = compiled(INPUTS_MODEL)

    def fitting(order_D: int, order_u: int) -> Fit:
        least = least_densities(resolved(record.sizes, record.T), record.T, order_D, order_u)
        numbers = before_a_fit(record, by_hand, order_D, order_u)
        return fitted(passes, tables, numbers, _free(OF_INPUTS, least, by_hand))

    return _likeliest(fitting, tried(by_hand, "order_D"), tried(by_hand, "order_u"), _rougher(tables), progress)


def before_a_fit(
    record: Record, by_hand: Mapping[str, float], order_D: int = _USUAL, order_u: int = _USUAL
) -> dict[str, float]:
    """The numbers of the first pass with densities as the sizes of the recording let expect them."""
    sizes, T = resolved(record.sizes, record.T), record.T
    least = least_densities(sizes, T, order_D, order_u)
    start = {name: max(value, least[name]) for name, value in densities(sizes, T, order_D, order_u).items()}
    orders = {"order_D": float(order_D), "order_u": float(order_u)}
    mine = _known(by_hand, INPUTS_MODEL.parameters)
    return {**record.numbers, **noise(record.sizes, T), **start, **orders, **mine}


def chosen_activations(
    record: Record, tables: Sequence[Array], first: Choice, by_hand: Mapping[str, float], progress: Progress = unseen
) -> Choice:
    """The model of the second pass; the tables are linear about the first."""
    passes, parameters = compiled(ACTIVATIONS_MODEL), ACTIVATIONS_MODEL.parameters
    # Δ_Φ is the same in both passes, and so is its order
    order_D, s_D = first.orders[0], first.fit.numbers["s_D"]
    least = least_of_law(parameters, OF_ACTIVATIONS)
    least["s_D"] = least_densities(resolved(record.sizes, record.T), record.T, order_D, _USUAL)["s_D"]
    free = _free(OF_ACTIVATIONS, least, by_hand)

    def fitting(order_D: int, order_a: int) -> Fit:
        defaults = {name: parameter.default for name, parameter in parameters.items()}
        own = {"s_D": max(s_D, least["s_D"]), "order_D": float(order_D), "order_a": float(order_a)}
        numbers = {**defaults, **_known(first.fit.numbers, parameters), **own, **_known(by_hand, parameters)}
        return fitted(passes, tables, numbers, free)

    orders = tried(by_hand, "order_a")
    ordering, last = shares(progress, [len(orders), 1])
    choice = _likeliest(fitting, [order_D], orders, _GAIN, ordering)
    choice = exact_if_likelier(passes, tables, choice, free, OF_LAW)
    last(1.0)
    return choice


def exact_if_likelier(
    passes: CompiledPasses, tables: Sequence[Array], choice: Choice, free: Mapping[str, float], of_law: Sequence[str]
) -> Choice:
    """The choice, or the same without the densities `of_law` that stand for what a line through Hill's law leaves.

    free: the least values of what is found.
    """
    # towards 0 the fixed point creeps, and log L hardly tells: it is asked for what the law leaves, or nothing
    others = {name: smallest for name, smallest in free.items() if name not in of_law}
    exact = {**choice.fit.numbers, **{name: free[name] for name in of_law if name in free}}
    without = fitted(passes, tables, exact, others)
    better = max((without, choice.fit), key=lambda fit: fit.log_likelihood)
    return replace(choice, fit=replace(better, passes=choice.fit.passes + without.passes))


def found_numbers(choice: Choice) -> dict[str, float]:
    """Noise, densities and orders by name, found or asked for; the others are the muscles', or start the filter."""
    return {name: value for name, value in choice.fit.numbers.items() if name.startswith(_FOUND)}


def manifest(choice: Choice) -> dict[str, Any]:
    """A choice in words of JSON."""
    return {
        "numbers": found_numbers(choice),
        "orders": list(choice.orders),
        "log_likelihood": choice.fit.log_likelihood,
        "passes": choice.fit.passes,
        "tried": {_written(orders): value for orders, value in choice.tried.items()},
        "needed": {_written(orders): value for orders, value in choice.needed.items()},
    }


def least_of_law(parameters: Parameters, names: Sequence[str]) -> dict[str, float]:
    """The least values of densities of the second pass."""
    return {name: _LEAST * parameters[name].default for name in names}


def likeliest_chain(
    fitting: Callable[[int], Fit], orders: Sequence[int], tables: Sequence[Array] | None = None
) -> Choice:
    """The likeliest order of one chain, the usual one first in the list.

    tables: what it is fitted to, if a lower order must gain more than chance makes.
    """
    fits: dict[Orders, Fit] = {(order,): fitting(order) for order in orders}
    usual, rougher = next(iter(fits)), _GAIN if tables is None else _rougher(tables)
    return _choice(fits, usual, _best(fits, usual, rougher), rougher)


def tried(by_hand: Mapping[str, float], name: str) -> list[int]:
    """The orders to be tried, the usual one first, unless one is given by hand."""
    return [int(by_hand[name])] if name in by_hand else [_USUAL, *_OTHERS]


def _rougher(tables: Sequence[Array]) -> float:
    """What orders below the usual ones must gain."""
    return max(_GAIN, _ROUGHER * sum(float(rows[:, -1].sum()) for rows in tables))


def _written(orders: Orders) -> str:
    return ",".join(map(str, orders))


def _likeliest(
    fitting: Fitting, of_D: Sequence[int], of_second: Sequence[int], rougher: float, progress: Progress
) -> Choice:
    """The usual orders, first in both lists, unless others gain enough; `rougher`: what orders below them must gain."""
    done, parts = itertools.count(1), len(of_second) + len(of_D) - 1

    def fit(order_D: int, second: int) -> Fit:
        found = fitting(order_D, second)
        progress(next(done) / parts)
        return found

    usual = of_D[0], of_second[0]
    fits: dict[Orders, Fit] = {(of_D[0], second): fit(of_D[0], second) for second in of_second}
    best = _best(fits, usual, rougher)
    fits |= {(order_D, best[1]): fit(order_D, best[1]) for order_D in of_D[1:]}
    return _choice(fits, usual, _best(fits, best, rougher), rougher)


def _choice(fits: Mapping[Orders, Fit], usual: Orders, best: Orders, rougher: float) -> Choice:
    likelihoods = {orders: found.log_likelihood for orders, found in fits.items()}
    return Choice(best, fits[best], likelihoods, {orders: _needed(orders, usual, rougher) for orders in fits})


def _best(fits: Mapping[Orders, Fit], usual: Orders, rougher: float) -> Orders:
    """The likeliest orders of those that gain enough over the usual ones."""

    def gain(orders: Orders) -> float:
        return fits[orders].log_likelihood - fits[usual].log_likelihood - _needed(orders, usual, rougher)

    best = max(fits, key=gain)
    return best if gain(best) > 0 else usual


def _needed(orders: Orders, usual: Orders, rougher: float) -> float:
    """What log L must gain over that of the usual orders; more if one of them is lower."""
    return rougher if any(order < least for order, least in zip(orders, usual, strict=True)) else _GAIN


def _free(names: Sequence[str], least: Mapping[str, float], by_hand: Mapping[str, float]) -> dict[str, float]:
    return {name: least[name] for name in names if name not in by_hand}


def _known(numbers: Mapping[str, float], names: Mapping[str, object]) -> dict[str, float]:
    return {name: value for name, value in numbers.items() if name in names}
