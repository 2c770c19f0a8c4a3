"""What follows from time and the step alone is computed once for all runs of a vector, not in each."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from .constants import closed, extracted, opened
from .lowering import as_written

# these roles run once and take the time itself
_ONCE = ("init", "scales", "constants")


def clocked(name: str, table: Mapping[str, ca.Function]) -> dict[str, ca.Function]:
    """The functions of a block (of `hoisted`) with a row of numbers in the place of t.

    One more, `clock(t, c)` → row, holds what they need of t, and of those constants that depend on the step alone.
    """
    moving = {role: f for role, f in table.items() if role not in _ONCE}
    t, c = ca.SX.sym("t"), ca.SX.sym("c", table["constants"].numel_out("c"))
    uniform = ca.vertcat(t, *(c[i] for i in _of_the_step(table["constants"])))
    with as_written():
        arguments, results = opened(moving, {"t": t, "c": c})
        reduced, symbols, values = _moving(*extracted(results, uniform), t)
        row = ca.SX.sym("t", len(symbols))
        reduced = ca.cse(ca.substitute(reduced, symbols, ca.vertsplit(row)) if symbols else reduced)
    clock = ca.cse(ca.densify(ca.vertcat(*values)))
    return {
        **{role: f for role, f in table.items() if role in _ONCE},
        "clock": ca.Function(f"{name}_clock", [t, c], [clock], ["t", "c"], ["row"]),
        **closed(name, moving, [{"t": row, **inputs, "c": c} for inputs in arguments], reduced),
    }


def _of_the_step(constants: ca.Function) -> list[int]:
    """Which of the constants depend on h alone."""
    of_numbers = constants.jac_sparsity(0, constants.index_in("p")).row()
    return [i for i in range(constants.numel_out(0)) if i not in of_numbers]


def _moving(
    reduced: list[ca.SX], symbols: list[ca.SX], values: list[ca.SX], t: ca.SX
) -> tuple[list[ca.SX], list[ca.SX], list[ca.SX]]:
    """The same, where values that do not depend on t are written back for their symbols."""
    pairs = list(zip(symbols, values, strict=True))
    moving = [pair for pair in pairs if ca.depends_on(pair[1], t)]
    still = [pair for pair in pairs if not ca.depends_on(pair[1], t)]
    reduced = ca.substitute(reduced, [symbol for symbol, _ in still], [value for _, value in still])
    return reduced, [symbol for symbol, _ in moving], [value for _, value in moving]
