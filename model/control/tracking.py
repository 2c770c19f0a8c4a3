"""A controller for any system: joints or points follow a reference, and what the muscles are free in is pretension.

The backstepping of backstepping.py for y = φ(q), with the accelerations of the system in the place of Newton's law.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from ..block import Block, BlockError, Parameter, Parameters, Symbols, symbols
from ..dialect import clamp, outside, solved
from ..fibre import along_fibres
from ..system import System
from .backstepping import PARAMETERS as OF_THE_PAIR
from .backstepping import riccati

REFERENCES = ("r", "dr", "ddr", "dddr")

_CHOSEN = "chosen, docs/mechanisms.md#control"
PARAMETERS: Parameters = {
    **{name: OF_THE_PAIR[name] for name in ("gamma", "q", "R", "u_max")},
    "k_c": Parameter(3.0, "rate at which muscles go to their co-contraction", _CHOSEN, least=0),
    "a_c": Parameter(0.2, "activation at rest that the pretension leads to", _CHOSEN, above=0, most=1),
}
# of the trace of G W Gᵀ: where all tendons are slack nothing can be asked of them
_RIDGE, _LEAST = 1e-12, 1e-12
# of the co-contraction: nearer to 0 an activation is pushed off no harder
_NEAR = 0.1


def tracking(system: System, tracked: Sequence[str]) -> Block:
    """Inputs: states, Delta and dDelta of joints, r, dr, ddr, dddr of each of `tracked`; outputs u of each muscle.

    tracked: places of the system, at most as many as it has joints and muscles. BlockError for another one.
    """
    _check(system, tracked)
    derivatives = [f"{kind}.{name}" for name in tracked for kind in REFERENCES]
    rates = [f"dDelta.{joint}" for joint in system.joints]
    u = symbols([*system.states, *system.joint("Delta"), *rates, *derivatives])
    parameters = {**PARAMETERS, **system.parameters, **system.curve_parameters}
    p = symbols(parameters)

    q, dq, Delta = (u.only(system.joint(signal)).vector() for signal in ("q", "dq", "Delta"))
    dDelta = u.only(rates).vector()
    L_S = u.only(system.muscle("L_S"))
    numbers = [p.part(muscle) for muscle in system.muscles]
    curves = [system.curves[muscle] for muscle in system.muscles]
    forces = [c.Phi_S(length, n) for c, length, n in zip(curves, L_S.values(), numbers, strict=True)]
    slopes = ca.vertcat(*(ca.jacobian(force, length) for force, length in zip(forces, L_S.values(), strict=True)))
    speeds = ca.vertcat(*(c.speed(n) for c, n in zip(curves, numbers, strict=True)))

    # y = φ(q),  ẏ = J q̇,  ÿ = J q̈ + J̇ q̇
    F = ca.SX.sym("F", len(forces))
    ddq = ca.vertcat(*system.accelerations(ca.vertsplit(q), ca.vertsplit(dq), ca.vertsplit(F), p)) + Delta
    places = system.places(ca.vertsplit(q))
    y = ca.vertcat(*(places[name] for name in tracked))
    dy = ca.jtimes(y, q, dq)
    ddy = ca.jacobian(dy, dq) @ ddq + ca.jtimes(dy, q, dq)
    # y⃛ = G u + …, since Ḟ = Φ′_S (L̇_m + u):  G = ∂ÿ/∂F Φ′_S
    by_force = ca.jacobian(ddy, F)
    G = by_force @ ca.diag(slopes)
    moved = ca.vertcat(*system.rates(ca.vertsplit(q), ca.vertsplit(dq), p))
    drift = (
        ca.jtimes(ddy, q, dq) + ca.jtimes(ddy, dq, ddq) + ca.jtimes(ddy, Delta, dDelta) + by_force @ (slopes * moved)
    )

    # step 1: e = y − r with the LQR of a double integrator;  w = ë + K (e, ė)
    K, P = riccati(Symbols(m=ca.SX(1), q=p.q, R=p.R))
    r, dr, ddr, dddr = (ca.vertcat(*(u[f"{kind}.{name}"] for name in tracked)) for kind in REFERENCES)
    e, de, dde = y - r, dy - dr, ddy - ddr
    w = dde + K[0] * e + K[1] * de
    # step 2: ẇ = −γ w − BᵀP (e, ė)
    wanted = dddr - K[0] * de - K[1] * dde - p.gamma * w - P[1, 0] * e - P[1, 1] * de

    # step 3: u = v + W Gᵀ(G W Gᵀ)⁻¹(b − G v), of all that do the one nearest to v, counted in what activations change
    a, rise = _at_rest(system, q, L_S, forces, slopes, p)
    # at rest ȧ = ∂a/∂F Φ′_S u:  W = diag(∂a/∂F Φ′_S)⁻²;  v makes Σ(½a² − a_c² log a) smaller
    near = ca.fmax(a, _NEAR * p.a_c)
    # below the least a tangent takes the place of 1/a
    push = p.a_c**2 / near * (2 - a / near) - a
    v, W = p.k_c * push / rise, ca.diag(1 / rise**2)
    square = G @ W @ G.T
    ridge = ca.fmax(_RIDGE * ca.trace(square), _LEAST) * ca.SX.eye(len(tracked))
    request = v + W @ G.T @ solved(square + ridge, wanted - drift - G @ v)
    request = ca.substitute(request, F, ca.vertcat(*forces))

    outputs, guards = Symbols(), Symbols()
    for muscle, value, most in zip(system.muscles, ca.vertsplit(request), ca.vertsplit(p.u_max * speeds), strict=True):
        outputs[system.name("u", muscle)] = clamp(value, -most, most)
        guards[f"{system.name('u', muscle)}_limit"] = outside(value, -most, most)
    return Block("controller", u=u, p=p, parameters=parameters, y=outputs, guards=guards)


def _at_rest(
    system: System, q: ca.SX, L_S: Symbols, forces: Sequence[ca.SX], slopes: ca.SX, p: Symbols
) -> tuple[ca.SX, ca.SX]:
    """The activations (muscles × 1) that hold these forces at rest, and how they rise with the tendons' lengths."""
    activations, rises = [], []
    lengths = system.lengths(ca.vertsplit(q), p)
    known = zip(system.muscles, lengths, L_S.values(), forces, ca.vertsplit(slopes), strict=True)
    for muscle, L_m, length, force, slope in known:
        numbers, F = p.part(muscle), ca.SX.sym("F")
        along, L_C, still = along_fibres(F, L_m, length, ca.SX(0), numbers)
        a = system.curves[muscle].activation(along, L_C, still, numbers)
        activations.append(ca.substitute(a, F, force))
        rises.append(ca.fmax(ca.substitute(ca.jacobian(a, F), F, force) * slope, _LEAST))
    return ca.vertcat(*activations), ca.vertcat(*rises)


def _check(system: System, tracked: Sequence[str]) -> None:
    known = system.places([ca.SX.sym(joint) for joint in system.joints])
    if unknown := [name for name in tracked if name not in known]:
        raise BlockError(f"{unknown[0]!r} cannot be tracked; there are {', '.join(known)}")
    most = min(len(system.joints), len(system.muscles))
    if not 0 < len(set(tracked)) == len(tracked) <= most:
        raise BlockError(f"{len(tracked)} places cannot be tracked; at most {most}, each once")
