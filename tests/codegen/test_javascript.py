"""JavaScript of CasADi's functions computes what CasADi does."""

import json
import subprocess

import casadi as ca
import numpy as np
import pytest

from hillobs.codegen.targets.javascript import javascript
from hillobs.model.block import BlockError
from tools import NODE, needs_node

x, y = ca.SX.sym("x"), ca.SX.sym("y")
ONE = "sqrt fabs exp log sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh expm1 log1p floor ceil sign"
TWO = "atan2 hypot fmax fmin logic_and logic_or"
EXPRESSIONS = {
    **{name: getattr(ca, name)(x) for name in ONE.split()},
    **{name: getattr(ca, name)(x, y) for name in TWO.split()},
    **{"+": x + y, "-": x - y, "*": x * y, "/": x / y, "**": x**y, "neg": -x, "sq": x**2, "x**3": x**3, "1/x": 1 / x},
    **{
        "twice": 2 * x,
        "<": x < y,
        "<=": x <= y,
        "==": x == y,
        "not": ca.logic_not(x),
        "!=": x != y,
        "if": ca.if_else(x < y, x, -y),
    },
    **{
        "constants": x + 1e-300 + 0.1 + 12345678901234567.0,
        "nan": ca.if_else(x < y, ca.SX.nan(1), x),
        "inf": x + ca.SX.inf(1),
    },
}
# negative ones, 0, the same twice, inside and outside the domains of roots and logarithms
POINTS = [(a, b) for a in (-1.5, -1.0, -0.3, 0.0, 0.7, 1.0, 2.5) for b in (-2.0, 0.0, 0.7, 1.0, 3.0)]


@needs_node
def test_each_operation_is_casadis() -> None:
    f = ca.Function("f", [x, y], [ca.densify(ca.vertcat(*EXPRESSIONS.values()))], ["x", "y"], ["values"])
    text = javascript(f, "f", ("x", "y"), ("values",))
    script = f"""
        const m = new Float64Array({len(EXPRESSIONS) + 2});
        const {{ f }} = {{ {text} }};
        console.log(JSON.stringify({json.dumps(POINTS)}.map(([x, y]) => {{
          m[0] = x, m[1] = y;
          f(0, 1, 2);
          return Array.from(m.slice(2), String);
        }})))
    """
    done = subprocess.run([NODE, "-e", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for point, row in zip(POINTS, json.loads(done.stdout), strict=True):
        found = np.array([float(value.replace("Infinity", "inf")) for value in row])
        expected = f(*point).full().ravel()
        # mathematics of two libraries: correct to a unit or two in the last place
        for name, mine, theirs in zip(EXPRESSIONS, found, expected, strict=True):
            np.testing.assert_allclose(mine, theirs, rtol=4e-15, atol=0, err_msg=f"{name} at {point}")


def test_an_operation_without_a_word_is_named() -> None:
    f = ca.Function("mine", [x], [ca.erf(x)], ["x"], ["y"])
    with pytest.raises(BlockError, match=r"^mine: CasADi's erf has no word in JavaScript$"):
        javascript(f, "mine", ("x",), ("y",))
