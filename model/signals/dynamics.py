"""How activation follows excitation."""

from __future__ import annotations

import casadi as ca

from ..block import Block, Parameter, Symbols, symbols

_SOURCE = "De Groote et al. 2016"
# s: time constants of rise and fall; and the slope of the switch between them
_RISE, _FALL, _STEEP = 0.015, 0.060, 10.0


def activation_dynamics(rate: float) -> Block:
    """The activation a that an excitation e makes; rate: what 1/s are in, as times are dimensionless.

    De Groote et al., Annals of Biomedical Engineering 2016, eq. 1 and 2.
    """
    parameters = {
        "rise": Parameter(_RISE * rate, "time constant at which activation rises", _SOURCE, above=0),
        "fall": Parameter(_FALL * rate, "time constant at which activation falls", _SOURCE, above=0),
        "a0": Parameter(0.1, "activation at the start", "chosen, docs/mechanisms.md#simulations", least=0, most=1),
    }
    x, u, p = symbols("a"), symbols("e"), symbols(parameters)
    # f = ½ tanh(b (e − a))
    f = 0.5 * ca.tanh(_STEEP * (u.e - x.a))
    # ȧ = [(f + ½)/(τ_a(½ + 3/2 a)) + (½ + 3/2 a)(½ − f)/τ_d] (e − a)
    slowed = 0.5 + 1.5 * x.a
    da = ((f + 0.5) / (p.rise * slowed) + slowed * (0.5 - f) / p.fall) * (u.e - x.a)
    return Block(
        "dynamics", x=x, u=u, p=p, parameters=parameters, dx=Symbols(a=da), x0=Symbols(a=p.a0), y=Symbols(a=x.a)
    )
