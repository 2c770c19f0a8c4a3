"""The reference r and its derivatives up to r‴."""

from __future__ import annotations

import casadi as ca

from ..block import Block, Parameter, Parameters, Symbols, symbols

_PAPER = "paper, §V"


def sine(u: Symbols, p: Symbols) -> ca.SX:
    """offset + amplitude sin(frequency t), the shape of all signals here."""
    return p.offset + p.amplitude * ca.sin(p.frequency * u.t)


def signal(offset: float, amplitude: float, frequency: float, what: str, source: str = _PAPER) -> Parameters:
    """The three numbers of such a signal."""
    return {
        "offset": Parameter(offset, f"mean of {what}", source),
        "amplitude": Parameter(amplitude, f"amplitude of {what}", source),
        "frequency": Parameter(frequency, f"angular frequency of {what}", source, least=0),
    }


def derivatives(y: ca.SX, t: ca.SX, names: list[str]) -> Symbols:
    """y, ẏ, ÿ … with respect to t under the names given."""
    result = Symbols({names[0]: y})
    for name in names[1:]:
        y = ca.jacobian(y, t)
        result[name] = y
    return result


def reference(offset: float = 2.6315, amplitude: float = 0.01, source: str = _PAPER) -> Block:
    """r = 2.6315 + 0.01 sin 0.5τ. Outputs r, dr, ddr, dddr."""
    u = symbols("t")
    parameters = signal(offset, amplitude, 0.5, "the reference", source)
    p = symbols(parameters)
    y = derivatives(sine(u, p), u.t, ["r", "dr", "ddr", "dddr"])
    return Block("reference", u=u, p=p, parameters=parameters, y=y)
