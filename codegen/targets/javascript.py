"""Functions of CasADi as JavaScript, an instruction a statement, for a page where there is no compiler."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from ...model.block import BlockError

# CasADi's operations on numbers; comparisons are 1 or 0 as CasADi's are
_OPERATIONS = {
    ca.OP_ADD: "{0}+{1}",
    ca.OP_SUB: "{0}-{1}",
    ca.OP_MUL: "{0}*{1}",
    ca.OP_DIV: "{0}/{1}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0}*{0}",
    ca.OP_TWICE: "2*{0}",
    ca.OP_INV: "1/{0}",
    ca.OP_SQRT: "Math.sqrt({0})",
    ca.OP_FABS: "Math.abs({0})",
    ca.OP_EXP: "Math.exp({0})",
    ca.OP_LOG: "Math.log({0})",
    ca.OP_POW: "Math.pow({0},{1})",
    ca.OP_CONSTPOW: "Math.pow({0},{1})",
    ca.OP_SIN: "Math.sin({0})",
    ca.OP_COS: "Math.cos({0})",
    ca.OP_TAN: "Math.tan({0})",
    ca.OP_ASIN: "Math.asin({0})",
    ca.OP_ACOS: "Math.acos({0})",
    ca.OP_ATAN: "Math.atan({0})",
    ca.OP_ATAN2: "Math.atan2({0},{1})",
    ca.OP_SINH: "Math.sinh({0})",
    ca.OP_COSH: "Math.cosh({0})",
    ca.OP_TANH: "Math.tanh({0})",
    ca.OP_ASINH: "Math.asinh({0})",
    ca.OP_ACOSH: "Math.acosh({0})",
    ca.OP_ATANH: "Math.atanh({0})",
    ca.OP_EXPM1: "Math.expm1({0})",
    ca.OP_LOG1P: "Math.log1p({0})",
    ca.OP_HYPOT: "Math.hypot({0},{1})",
    ca.OP_FLOOR: "Math.floor({0})",
    ca.OP_CEIL: "Math.ceil({0})",
    ca.OP_SIGN: "Math.sign({0})",
    # what is no number stays none
    ca.OP_FMAX: "Math.max({0},{1})",
    ca.OP_FMIN: "Math.min({0},{1})",
    ca.OP_LT: "+({0}<{1})",
    ca.OP_LE: "+({0}<={1})",
    ca.OP_EQ: "+({0}==={1})",
    ca.OP_NE: "+({0}!=={1})",
    ca.OP_NOT: "+!{0}",
    ca.OP_AND: "+({0}&&{1}?1:0)",
    ca.OP_OR: "+({0}||{1}?1:0)",
    ca.OP_IF_ELSE_ZERO: "({0}?{1}:0)",
    ca.OP_ASSIGN: "{0}",
}


def javascript(function: ca.Function, name: str, arguments: Sequence[str], results: Sequence[str]) -> str:
    """A function of JavaScript that reads and writes the array `m`, from where each argument and result begins in it.

    arguments, results: names in the order of the call; what CasADi's function does not have is not looked at.
    BlockError for an operation that JavaScript has no word for.
    """
    given, returned = function.name_in(), function.name_out()
    statements = []
    for i in range(function.n_instructions()):
        kind, operands, targets = (
            function.instruction_id(i),
            function.instruction_input(i),
            function.instruction_output(i),
        )
        match kind:
            case ca.OP_INPUT:
                statements.append(f"w{targets[0]}=m[{given[operands[0]]}+{operands[1]}]")
            case ca.OP_OUTPUT:
                statements.append(f"m[{returned[targets[0]]}+{targets[1]}]=w{operands[0]}")
            case ca.OP_CONST:
                statements.append(f"w{targets[0]}={_literal(function.instruction_constant(i))}")
            case _ if kind in _OPERATIONS:
                words = [f"w{operand}" for operand in operands]
                statements.append(f"w{targets[0]}={_OPERATIONS[kind].format(*words)}")
            case _:
                raise BlockError(f"{function.name()}: CasADi's {_word(kind)} has no word in JavaScript")
    variables = ",".join(f"w{i}=0" for i in range(function.sz_w()))
    begin = f"let {variables};" if variables else ""
    return f"{name}({','.join([*arguments, *results])}){{{begin}{';'.join(statements)}}}"


def _word(kind: int) -> str:
    """What CasADi calls an operation: erf."""
    names = {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}
    return names[kind].removeprefix("OP_").lower()


def _literal(value: float) -> str:
    return {"inf": "Infinity", "-inf": "-Infinity", "nan": "NaN"}.get(repr(value), repr(value))
