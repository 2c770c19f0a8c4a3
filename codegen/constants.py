"""What follows from the parameters alone is computed once a run, not at every stage."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

# roles that keep the parameters: they run once
_ONCE = ("init",)


def hoisted(name: str, table: Mapping[str, ca.Function]) -> dict[str, ca.Function]:
    """The functions of a block (roles of `stepper`) with constants `c` in the place of p and h, and
    `constants(h, p)` → c, which holds what they need of p, h and what follows from them.
    """
    moving = {role: f for role, f in table.items() if role not in _ONCE}
    h, p = ca.SX.sym("h"), ca.SX.sym("p", table["init"].numel_in("p"))
    arguments, results = {}, {}
    for role, f in moving.items():
        own = {"h": h, "p": p}
        inputs = [own.get(n) if n in own else ca.SX.sym(n, *f.size_in(n)) for n in f.name_in()]
        arguments[role] = {n: s for n, s in zip(f.name_in(), inputs, strict=True) if n not in own}
        results[role] = f.call(inputs)
    every = ca.cse([e for outputs in results.values() for e in outputs])
    reduced, symbols, constants = ca.extract_parametric(every, ca.vertcat(h, p), {"extract_trivial": True})
    c = ca.SX.sym("c", len(symbols))
    reduced = ca.substitute(reduced, [ca.vertcat(*symbols)], [c]) if symbols else reduced
    done = {role: f for role, f in table.items() if role in _ONCE}
    done["constants"] = ca.Function(
        f"{name}_constants", [h, p], [ca.densify(ca.vertcat(*constants))], ["h", "p"], ["c"]
    )
    for role, f in moving.items():
        outputs, reduced = reduced[: f.n_out()], reduced[f.n_out() :]
        inputs = list(arguments[role])
        done[role] = ca.Function(
            f"{name}_{role}", [*arguments[role].values(), c], ca.cse(outputs), [*inputs, "c"], f.name_out()
        )
    return done
