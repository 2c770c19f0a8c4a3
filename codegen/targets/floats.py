"""Functions as floats want them, which have seven digits: the same equations, with other roundings."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from ..lowering import as_written, plain, rewritten

Operation = Callable[[int, list[ca.SX]], ca.SX]


def without_literals(f: ca.Function) -> ca.Function:
    """The same function, so that CasADi writes no number within an expression: it would be a double among floats."""

    def operation(kind: int, operands: list[ca.SX]) -> ca.SX:
        match kind:
            case ca.OP_TWICE:  # 2.*x
                return operands[0] + operands[0]
            case ca.OP_INV:  # 1./x
                return ca.SX(1) / operands[0]
            case _:
                return plain(kind, operands)

    return _changed(f, lambda inputs: operation)


def summed_apart(f: ca.Function, argument: str) -> ca.Function:
    """The same function, where sums that begin with an element of an argument add that last.

    A state of size 2 that moves by 10⁻⁵ a sample keeps two digits of each summand, added one by one; added together
    before they keep seven.
    """

    def begun(inputs: list[ca.SX]) -> Operation:
        vector = inputs[f.name_in().index(argument)]
        # hash of a value → the element that it begins with, what is added to that; and the value, so that it stays
        sums = {e.element_hash(): (e, ca.SX(0), e) for e in ca.vertsplit(vector)} if vector.numel() else {}

        def summed(element: ca.SX, rest: ca.SX) -> ca.SX:
            value = element + rest
            sums[value.element_hash()] = (element, rest, value)
            return value

        def operation(kind: int, operands: list[ca.SX]) -> ca.SX:
            known = [sums.get(operand.element_hash()) for operand in operands]
            match kind, known:
                case ca.OP_ADD, [(element, rest, _), None]:
                    return summed(element, _plus(rest, operands[1]))
                case ca.OP_ADD, [None, (element, rest, _)]:
                    return summed(element, _plus(rest, operands[0]))
                case ca.OP_SUB, [(element, rest, _), None]:
                    return summed(element, rest - operands[1])
                case ca.OP_SUB, [None, (element, rest, _)]:
                    return (operands[0] - element) - rest
                case _:
                    return plain(kind, operands)

        return operation

    return _changed(f, begun)


def _plus(rest: ca.SX, summand: ca.SX) -> ca.SX:
    return summand if rest.is_zero() else rest + summand


def _changed(f: ca.Function, change: Callable[[list[ca.SX]], Operation]) -> ca.Function:
    """The same function with another operation for each of its own."""
    inputs = [ca.SX.sym(f.name_in(i), f.size1_in(i), f.size2_in(i)) for i in range(f.n_in())]
    scalars = [scalar for matrix in inputs for scalar in ca.vertsplit(ca.vec(matrix))]
    operation = change(inputs)
    with as_written():
        expressions = f.call(inputs)
        flat = ca.Function("f", scalars, expressions)
        results = rewritten(flat, scalars, expressions, lambda k, operands: operation(flat.instruction_id(k), operands))
        return ca.Function(f.name(), inputs, results, f.name_in(), f.name_out())
