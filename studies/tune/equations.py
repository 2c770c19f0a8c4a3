"""Numbers that follow from others: where a gain condition is an equation, such as α₀ = 2√(2β₀), one is not tuned."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ...model.arrays import Array
from ..scenarios.prepare import Prepared
from ..simulate.conditions import conditions_of


@dataclass(frozen=True)
class Equation:
    """The number at `path` is `function` of those at `sources`."""

    path: str
    function: ca.Function
    sources: tuple[str, ...]

    def solved(self, prepared: Prepared, values: Mapping[str, Array], count: int) -> Array:
        """(count) what the number is, with `values` (count) at some paths, and the scenario's numbers elsewhere."""
        given = {member: column for path, column in values.items() for member in prepared.paths.expand(path)}
        columns = [given.get(path, np.full(count, prepared.value(path))) for path in self.sources]
        found: Array = np.array(self.function(np.array(columns)), dtype=float).ravel()
        return found


def equations(prepared: Prepared) -> Iterator[Equation]:
    """Those of the observers that run."""
    for block, conditions, known in conditions_of(prepared):
        of_symbol = {symbol.name(): f"{block.name}.{name}" for name, symbol in known.only(block.p).items()}
        for condition in conditions:
            path = of_symbol.get(condition.left.name()) if condition.left.is_symbolic() else None
            if condition.relation == "=" and path is not None:
                function = ca.Function("number", [known.only(block.p).vector()], [condition.right])
                yield Equation(path, function, tuple(of_symbol.values()))
