"""A CasADi function as Python source, one line per instruction, for numbers or for arrays of any module."""

from __future__ import annotations

import importlib
import linecache
from collections.abc import Callable, Collection, Mapping, Sequence
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
    """`def name(arguments): … return results`, each a sequence of numbers or arrays."""
    lines, results = _lines(f, dialect, lambda name, i: f"{name}[{i}]")
    # a comma behind each entry: one alone, or none, is a tuple too
    tuples = "".join(f"({''.join(f'{entry}, ' for entry in entries)}), " for entries in results)
    return _definition(f, [*lines, f"return ({tuples})"])


def loop_source(f: ca.Function, runs: int, own: Collection[str], result: str) -> str:
    """The same for numbers in flat arrays (numbers × runs), run by run: a loop that a compiler can turn into vectors.

    own: the arguments that each run has for itself; result: which of them is overwritten by the one result.
    """
    lines, (results,) = _lines(
        f, NUMBERS, lambda name, i: f"{name}[{i * runs} + run]" if name in own else f"{name}[{i}]"
    )
    lines += [f"{result}[{i * runs} + run] = {value}" for i, value in enumerate(results)]
    return _definition(f, [f"for run in range({runs}):", *(f"    {line}" for line in lines)])


def python(f: ca.Function, dialect: Dialect) -> Callable[..., Any]:
    """The function that `source` describes."""
    return _function(f, dialect, source(f, dialect))


def in_loop(f: ca.Function, runs: int, own: Collection[str], result: str) -> Callable[..., None]:
    """The function that `loop_source` describes."""
    return _function(f, NUMBERS, loop_source(f, runs, own, result))


def _lines(f: ca.Function, dialect: Dialect, element: Callable[[str, int], str]) -> tuple[list[str], list[list[str]]]:
    """A line per instruction, and the names of the results. ValueError for an operation that is not known."""
    lines, results = [], [["0.0"] * f.numel_out(i) for i in range(f.n_out())]
    for k in range(f.n_instructions()):
        operation = f.instruction_id(k)
        operands, targets = f.instruction_input(k), f.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            i, j = targets
            results[i][j] = f"r{i}_{j}"
            lines.append(f"r{i}_{j} = a{operands[0]}")
        elif operation == ca.OP_INPUT:
            lines.append(f"a{targets[0]} = {element(f.name_in(operands[0]), operands[1])}")
        elif operation == ca.OP_CONST:
            lines.append(f"a{targets[0]} = {f.instruction_constant(k)!r}")
        elif operation in dialect.operations:
            words = dialect.operations[operation].format(*(f"a{i}" for i in operands))
            lines.append(f"a{targets[0]} = {words}")
        else:
            raise ValueError(f"{f.name()}: instruction {k} is an operation that has no Python here")
    return lines, results


def _definition(f: ca.Function, lines: Sequence[str]) -> str:
    return "\n    ".join([f"def {f.name()}({', '.join(f.name_in())}):", *lines]) + "\n"


def _function(f: ca.Function, dialect: Dialect, text: str) -> Callable[..., Any]:
    name = f"<{f.name()} for {dialect.module}>"
    space: dict[str, Any] = dict(vars(importlib.import_module(dialect.module)))
    # tracebacks and numba ask for the lines of a function
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
    exec(compile(text, name, "exec"), space)  # noqa: S102  the text is ours, from operations and numbers alone
    made: Callable[..., Any] = space[f.name()]
    return made
