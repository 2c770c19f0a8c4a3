"""What follows from time and the step alone is computed once for all runs of a batch, not in each."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from .constants import extracted
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
    arguments: dict[str, dict[str, ca.SX]] = {}
    results: list[ca.SX] = []
    with as_written():
        for role, f in moving.items():
            own = {"t": t, "c": c}
            arguments[role] = {n: own.get(n, ca.SX.sym(n, *f.size_in(n))) for n in f.name_in()}
            results += f.call(list(arguments[role].values()))
        reduced, symbols, values = _moving(*extracted(results, uniform), t)
        row = ca.SX.sym("t", len(symbols))
        reduced = ca.cse(ca.substitute(reduced, symbols, ca.vertsplit(row)) if symbols else reduced)
    done = {role: f for role, f in table.items() if role in _ONCE}
    clock = ca.cse(ca.densify(ca.vertcat(*values)))
    done["clock"] = ca.Function(f"{name}_clock", [t, c], [clock], ["t", "c"], ["row"])
    for role, f in moving.items():
        outputs, reduced = reduced[: f.n_out()], reduced[f.n_out() :]
        inputs = {**arguments[role], "t": row}
        done[role] = ca.Function(f"{name}_{role}", [*inputs.values()], outputs, [*inputs], f.name_out())
    return done


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
