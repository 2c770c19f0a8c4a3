"""One Hill muscle: a fibre in series with a tendon, driven by its virtual input or by its activation."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from .block import Block, Parameter, Parameters, Symbols, symbols
from .curves import CurveSet
from .dialect import clamp, outside
from .fibre import along_fibres, muscle_parameters

# keeps 0/0 out of the stiffness where the force does not depend on the velocity
_RIGID = 1e-12
ACTIVATION_LIMITS: Parameters = {
    "a_min": Parameter(
        0.01, "smallest activation that a muscle can be given", "chosen, docs/model.md#drives", above=0, below=1
    ),
    "z_max": Parameter(
        1.45, "largest force factor z: g(−0.9), below the pole g_max", "chosen, docs/model.md#drives", above=1, most=100
    ),
}


def _muscle(
    curves: CurveSet, oblique: bool, drive: Symbols, extra: Parameters
) -> tuple[Symbols, Symbols, Symbols, Parameters]:
    parameters = {**muscle_parameters(curves, oblique), **extra}
    return symbols("L_S"), Symbols({**symbols("L_m dL_m"), **drive}), symbols(parameters), parameters


def virtual_muscle(curves: CurveSet, oblique: bool = False) -> Block:
    """Driven by u. Inputs L_m, dL_m (length and its rate), u; outputs Phi_S, L_C, u, a, taut.

    oblique: its fibres are at an angle to the tendon, by the parameter pennation.
    """
    x, u, p, parameters = _muscle(curves, oblique, symbols("u"), {})
    Phi_S = curves.Phi_S(x.L_S, p)
    force, L_C, shortening = along_fibres(Phi_S, u.L_m, x.L_S, u.u, p)
    a = curves.activation(force, L_C, shortening, p)
    # L̇_S = L̇_m + u   [lsdot1], [lsdot2]
    return _block(
        x, u, p, parameters, Phi_S, L_C, drive=u.u, a=a, guards=Symbols(a_infeasible=(Phi_S > 0) * outside(a, 0, 1))
    )


def activated_muscle(curves: CurveSet, oblique: bool = False) -> Block:
    """Driven by the activation a, limited to [a_min, 1]. Inputs L_m, dL_m, a; outputs as those of `virtual_muscle`.

    And `stiffness`: the rate at which the tendon comes to rest, −∂L̇_S/∂L_S, which an integration step has to resolve.
    """
    x, u, p, parameters = _muscle(curves, oblique, symbols("a"), ACTIVATION_LIMITS)
    a = clamp(u.a, p.a_min, 1)
    Phi_S = curves.Phi_S(x.L_S, p)
    force, L_C, share = along_fibres(Phi_S, u.L_m, x.L_S, ca.SX(1), p)
    shortening, z_limit = curves.velocity(force, L_C, a, p, p.z_max)
    # L_m − L_S shrinks with u, the fibre with u cos α
    drive = shortening / share
    guards = Symbols(a_limit=outside(u.a, p.a_min, 1), z_limit=z_limit)
    block = _block(x, u, p, parameters, Phi_S, L_C, drive=drive, a=a, guards=guards)
    stiffness = (1 - z_limit) * _stiffness(curves, x.L_S, u.L_m, a, drive, p)
    return replace(block, y=Symbols({**block.y, "stiffness": stiffness}))


def _stiffness(curves: CurveSet, L_S: ca.SX, L_m: ca.SX, a: ca.SX, drive: ca.SX, p: Symbols) -> ca.SX:
    """−∂u/∂L_S of the u that balances tendon and fibres, by the implicit function theorem."""
    at, v = ca.SX.sym("L_S"), ca.SX.sym("u")
    along, L_C, shortening = along_fibres(curves.Phi_S(at, p), L_m, at, v, p)
    # E(L_S, u) = 0:  −∂u/∂L_S = ∂E/∂L_S/∂E/∂u
    E = along - curves.force(L_C, a, shortening, p)
    ratio = ca.jacobian(E, at) / ca.fmax(ca.jacobian(E, v), _RIGID)
    return ca.substitute(ratio, ca.vertcat(at, v), ca.vertcat(L_S, drive))


def requested_activation(curves: CurveSet, oblique: bool = False) -> Block:
    """The activation that the controller's request u asks for. Inputs L_m, L_S, u; output a, not yet limited."""
    parameters = muscle_parameters(curves, oblique)
    u, p = symbols("L_m L_S u"), symbols(parameters)
    force = curves.Phi_S(u.L_S, p)
    y = Symbols(a=curves.activation(*along_fibres(force, u.L_m, u.L_S, u.u, p), p))
    return Block("request", u=u, p=p, parameters=parameters, y=y)


def _block(
    x: Symbols,
    u: Symbols,
    p: Symbols,
    parameters: Parameters,
    Phi_S: ca.SX,
    L_C: ca.SX,
    drive: ca.SX,
    a: ca.SX,
    guards: Symbols,
) -> Block:
    L_S0 = ca.SX.sym("L_S0")
    start = {"L_S0": Parameter(2.018, "tendon length at the start", "chosen, docs/model.md#start", above=0)}
    return Block(
        "muscle",
        x=x,
        u=u,
        p=Symbols({**p, "L_S0": L_S0}),
        parameters={**parameters, **start},
        dx=Symbols(L_S=u.dL_m + drive),
        x0=Symbols(L_S=L_S0),
        y=Symbols(L_S=x.L_S, Phi_S=Phi_S, L_C=L_C, u=drive, a=a, taut=Phi_S > 0),
        guards=guards,
        domain=Symbols(L_S=x.L_S, L_C=L_C),
    )
