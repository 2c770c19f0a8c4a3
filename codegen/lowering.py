"""Expressions as the lanes want them: no branch, few divisions."""

from __future__ import annotations

import collections
import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence

import casadi as ca

# far enough from overflow to be multiplied by 1
_HUGE = 1e300


@contextlib.contextmanager
def as_written() -> Iterator[None]:
    """CasADi leaves expressions as they are written; else it makes `y/x` of `(1/x)·y` again."""
    before = ca.GlobalOptions.getSimplificationOnTheFly()
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        ca.GlobalOptions.setSimplificationOnTheFly(before)


def lowered(expressions: Sequence[ca.SX], inputs: Sequence[ca.SX], reciprocals: Mapping[int, ca.SX]) -> list[ca.SX]:
    """The same expressions in the symbols `inputs` (scalars), operation by operation; to be used `as_written`.

    reciprocals: hash of a symbol → symbol for its reciprocal; a division by the former multiplies by the latter. So do
    several divisions by one value.
    """
    f = ca.Function("f", inputs, [ca.densify(expression) for expression in expressions])
    divisors = _divisors(f)
    inverses: dict[int, ca.SX] = {}

    def operation(k: int, operands: list[ca.SX]) -> ca.SX:
        if k not in divisors:
            return _operation(f.instruction_id(k), operands, reciprocals)
        divisor = operands[-1]
        known = reciprocals.get(divisor.element_hash()) if divisor.is_symbolic() else None
        inverse = inverses.setdefault(divisors[k], 1 / divisor if known is None else known)
        return operands[0] * inverse if f.instruction_id(k) == ca.OP_DIV else inverse

    return rewritten(f, inputs, expressions, operation)


def rewritten(
    f: ca.Function,
    inputs: Sequence[ca.SX],
    expressions: Sequence[ca.SX],
    operation: Callable[[int, list[ca.SX]], ca.SX],
) -> list[ca.SX]:
    """The results of f, of the shapes of `expressions`, with `operation` in the place of each of its instructions."""
    work: dict[int, ca.SX] = {}
    results = [[ca.SX(0)] * expression.numel() for expression in expressions]
    for k in range(f.n_instructions()):
        operands, targets = f.instruction_input(k), f.instruction_output(k)
        if f.instruction_id(k) == ca.OP_OUTPUT:
            results[targets[0]][targets[1]] = work[operands[0]]
        elif f.instruction_id(k) == ca.OP_INPUT:
            work[targets[0]] = inputs[operands[0]]
        elif f.instruction_id(k) == ca.OP_CONST:
            work[targets[0]] = ca.SX(f.instruction_constant(k))
        else:
            work[targets[0]] = operation(k, [work[i] for i in operands])
    return [
        ca.reshape(ca.vertcat(*entries), expression.shape) if entries else expression
        for entries, expression in zip(results, expressions, strict=True)
    ]


# CasADi writes both with a branch
_BRANCHES = (ca.OP_SIGN, ca.OP_IF_ELSE_ZERO)


def without_branches(f: ca.Function) -> ca.Function:
    """The same function, lowered if it has a branch."""
    if not any(f.instruction_id(k) in _BRANCHES for k in range(f.n_instructions())):
        return f
    inputs = [ca.SX.sym(f.name_in(i), f.size1_in(i), f.size2_in(i)) for i in range(f.n_in())]
    with as_written():
        scalars = [scalar for matrix in inputs for scalar in ca.vertsplit(ca.vec(matrix))]
        return ca.Function(f.name(), inputs, lowered(f.call(inputs), scalars, {}), f.name_in(), f.name_out())


def _divisors(f: ca.Function) -> dict[int, int]:
    """The divisions by a value that is a divisor more than once: instruction → instruction that made the value."""
    made: dict[int, int] = {}
    found: dict[int, int] = {}
    for k in range(f.n_instructions()):
        if f.instruction_id(k) in (ca.OP_DIV, ca.OP_INV):
            found[k] = made[f.instruction_input(k)[-1]]
        if f.instruction_id(k) != ca.OP_OUTPUT:
            made[f.instruction_output(k)[0]] = k
    often = collections.Counter(found.values())
    return {k: value for k, value in found.items() if often[value] > 1}


def _operation(operation: int, operands: Sequence[ca.SX], reciprocals: Mapping[int, ca.SX]) -> ca.SX:
    first, last = operands[0], operands[-1]
    if operation == ca.OP_IF_ELSE_ZERO:
        # c ? x : 0 is c x, for an x that may be infinite where c is 0
        return (first != 0) * ca.fmin(ca.fmax(-_HUGE, last), _HUGE)
    if operation == ca.OP_SIGN:
        return (first > 0) - (first < 0)
    if last.is_symbolic() and (reciprocal := reciprocals.get(last.element_hash())) is not None:
        if operation == ca.OP_DIV:
            return first * reciprocal
        if operation == ca.OP_INV:
            return reciprocal
    return plain(operation, operands)


def plain(operation: int, operands: Sequence[ca.SX]) -> ca.SX:
    """An operation of CasADi as it is."""
    return ca.SX.unary(operation, operands[0]) if len(operands) == 1 else ca.SX.binary(operation, *operands)
