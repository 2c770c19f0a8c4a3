"""What follows from the parameters alone is computed once a run, not at every stage."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import casadi as ca

from .lowering import as_written, lowered
from .stepper import compiled

# these roles run once and take the parameters themselves
_ONCE = ("init", "scales")


def hoisted(name: str, table: Mapping[str, ca.Function]) -> dict[str, ca.Function]:
    """The functions of a block (roles of `stepper`) with constants `c` in the place of p and h.

    One more, `constants(h, p)` → c, holds what they need of p, h and what follows from them.
    """
    moving = {role: f for role, f in compiled(table).items() if role not in _ONCE}
    h, p = ca.SX.sym("h"), ca.SX.sym("p", table["init"].numel_in("p"))
    arguments, results = opened(moving, {"h": h, "p": p})
    with as_written():
        reduced, symbols, values = extracted(ca.cse(results), ca.vertcat(h, p))
        c = ca.SX.sym("c", len(symbols))
        reduced = ca.cse(ca.substitute(reduced, [ca.vertcat(*symbols)], [c]) if symbols else reduced)
    constants = ca.cse(ca.densify(ca.vertcat(*values)))
    done = {
        **{role: table[role] for role in _ONCE if role in table},
        "constants": ca.Function(f"{name}_constants", [h, p], [constants], ["h", "p"], ["c"]),
    }
    return {**done, **closed(name, moving, [{**inputs, "c": c} for inputs in arguments], reduced)}


def opened(table: Mapping[str, ca.Function], own: Mapping[str, ca.SX]) -> tuple[list[dict[str, ca.SX]], list[ca.SX]]:
    """The other arguments of each function, as fresh symbols, and the results of all, one list, in these and `own`."""
    arguments, results = [], []
    for f in table.values():
        inputs = {n: own[n] if n in own else ca.SX.sym(n, *f.size_in(n)) for n in f.name_in()}
        arguments.append({n: symbol for n, symbol in inputs.items() if n not in own})
        results += f.call(list(inputs.values()))
    return arguments, results


def closed(
    name: str, table: Mapping[str, ca.Function], arguments: Sequence[Mapping[str, ca.SX]], results: Sequence[ca.SX]
) -> dict[str, ca.Function]:
    """Functions of a block again, by the roles of `table`, of `arguments` and with what has become of their results."""
    done, rest = {}, iter(results)
    for (role, f), inputs in zip(table.items(), arguments, strict=True):
        outputs = list(itertools.islice(rest, f.n_out()))
        done[role] = ca.Function(f"{name}_{role}", [*inputs.values()], outputs, [*inputs], f.name_out())
    return done


def extracted(expressions: list[ca.SX], parameters: ca.SX) -> tuple[list[ca.SX], list[ca.SX], list[ca.SX]]:
    """The expressions without the parameters, the constants in them, and what these are in terms of the parameters."""
    reduced, symbols, values = ca.extract_parametric(expressions, parameters, {"extract_trivial": True})
    inverses = [ca.SX.sym("inverse") for _ in symbols]
    reciprocals = {symbol.element_hash(): inverse for symbol, inverse in zip(symbols, inverses, strict=True)}
    reduced = lowered(reduced, _free(reduced), reciprocals)
    used = {symbol.element_hash() for symbol in _free(reduced)}
    both = [*zip(symbols, values, strict=True), *((r, 1 / v) for r, v in zip(inverses, values, strict=True))]
    kept = [pair for pair in both if pair[0].element_hash() in used]
    return reduced, [symbol for symbol, _ in kept], [value for _, value in kept]


def _free(expressions: list[ca.SX]) -> list[ca.SX]:
    return ca.symvar(ca.vertcat(*(ca.vec(expression) for expression in expressions)))
