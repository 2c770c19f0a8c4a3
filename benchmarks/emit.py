"""A CasADi function as Python source, one line per instruction, for numbers or for arrays of any module."""

from __future__ import annotations

import importlib
import linecache
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

_COMMON = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "{0} + {0}",
    ca.OP_CONSTPOW: "{0} ** {1}",
    ca.OP_POW: "{0} ** {1}",
}
# each of these differs between numbers and arrays; a comparison is 1.0 or 0.0, as in C
_OF_NUMBERS = {
    ca.OP_SQRT: "sqrt({0})",
    ca.OP_SIN: "sin({0})",
    ca.OP_COS: "cos({0})",
    ca.OP_EXP: "exp({0})",
    ca.OP_FABS: "abs({0})",
    ca.OP_FMIN: "({1} if {1} < {0} else {0})",
    ca.OP_FMAX: "({1} if {1} > {0} else {0})",
    ca.OP_LT: "(1.0 if {0} < {1} else 0.0)",
    ca.OP_LE: "(1.0 if {0} <= {1} else 0.0)",
    ca.OP_EQ: "(1.0 if {0} == {1} else 0.0)",
    ca.OP_NE: "(1.0 if {0} != {1} else 0.0)",
    ca.OP_NOT: "(1.0 if {0} == 0.0 else 0.0)",
    ca.OP_AND: "(1.0 if {0} != 0.0 and {1} != 0.0 else 0.0)",
    ca.OP_OR: "(1.0 if {0} != 0.0 or {1} != 0.0 else 0.0)",
}
_OF_ARRAYS = {
    ca.OP_SQRT: "sqrt({0})",
    ca.OP_SIN: "sin({0})",
    ca.OP_COS: "cos({0})",
    ca.OP_EXP: "exp({0})",
    ca.OP_FABS: "abs({0})",
    ca.OP_FMIN: "minimum({0}, {1})",
    ca.OP_FMAX: "maximum({0}, {1})",
    ca.OP_LT: "({0} < {1}) * 1.0",
    ca.OP_LE: "({0} <= {1}) * 1.0",
    ca.OP_EQ: "({0} == {1}) * 1.0",
    ca.OP_NE: "({0} != {1}) * 1.0",
    ca.OP_NOT: "({0} == 0.0) * 1.0",
    ca.OP_AND: "logical_and({0} != 0.0, {1} != 0.0) * 1.0",
    ca.OP_OR: "logical_or({0} != 0.0, {1} != 0.0) * 1.0",
}


@dataclass(frozen=True)
class Dialect:
    """Where the functions come from, and how an operation is written."""

    module: str
    operations: Mapping[int, str]


NUMBERS = Dialect("math", _COMMON | _OF_NUMBERS)
NUMPY = Dialect("numpy", _COMMON | _OF_ARRAYS)
JAX = Dialect("jax.numpy", _COMMON | _OF_ARRAYS)


def source(f: ca.Function, dialect: Dialect) -> str:
    """`def name(arguments): … return results`, of sequences of numbers or arrays. ValueError for an operation unknown."""
    lines, results = [], [["0.0"] * f.numel_out(i) for i in range(f.n_out())]
    for k in range(f.n_instructions()):
        operation = f.instruction_id(k)
        operands, targets = f.instruction_input(k), f.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            results[targets[0]][targets[1]] = f"r{targets[0]}_{targets[1]}"
            line = f"r{targets[0]}_{targets[1]} = a{operands[0]}"
        elif operation == ca.OP_INPUT:
            line = f"a{targets[0]} = {f.name_in(operands[0])}[{operands[1]}]"
        elif operation == ca.OP_CONST:
            line = f"a{targets[0]} = {f.instruction_constant(k)!r}"
        elif operation in dialect.operations:
            words = [f"a{i}" for i in operands]
            line = f"a{targets[0]} = " + dialect.operations[operation].format(*words)
        else:
            raise ValueError(f"{f.name()}: instruction {k} is an operation that has no Python here")
        lines.append(f"    {line}\n")
    tuples = ", ".join(f"({', '.join(entries)},)" for entries in results)
    return f"def {f.name()}({', '.join(f.name_in())}):\n{''.join(lines)}    return {tuples}\n"


def python(f: ca.Function, dialect: Dialect) -> Callable[..., Any]:
    """The function that `source` describes."""
    text, name = source(f, dialect), f"<{f.name()} for {dialect.module}>"
    space: dict[str, Any] = dict(vars(importlib.import_module(dialect.module)))
    # tracebacks and numba ask for the lines of a function
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
    exec(compile(text, name, "exec"), space)  # noqa: S102  the text is ours, from operations and numbers alone
    return space[f.name()]
