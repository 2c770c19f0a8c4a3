"""Where a system starts: joints at rest or in motion, and tendons such that joints accelerate as little as can be."""

from __future__ import annotations

import casadi as ca

from ..block import Parameter, Parameters, Symbols
from ..dialect import solved
from ..fibre import along_fibres
from ..system import System

_CHOSEN = "chosen, docs/mechanisms.md#start"
# each brings the fibres nearer to the length that they have when their tendon is stretched
_ROUNDS = 5
# each finds muscles that cannot balance by pulling
_TURNS = 6
# first guess of a force, and the least, as parts of the force at which a tendon is straight
_GUESS, _LEAST = 0.2, 0.01
_RIDGE = 1e-12


def start_parameters(system: System) -> Parameters:
    """`initial.elbow.q`, `initial.elbow.dq` of joints and `initial.BRA.a` of muscles."""
    words = {"q": "coordinate", "dq": "its rate"}
    return {
        **{
            f"initial.{system.name(signal, joint)}": Parameter(0.0, f"{joint}: {what} at the start", _CHOSEN)
            for joint in system.joints
            for signal, what in words.items()
        },
        **{
            f"initial.{system.name('a', muscle)}": Parameter(
                0.1, f"{muscle}: its activation is near this at the start", _CHOSEN, least=0, most=1
            )
            for muscle in system.muscles
        },
    }


def start(system: System, p: Symbols) -> Symbols:
    """x(0) of joints and tendons: of the forces that accelerate no joint those nearest to the activations asked for.

    Where that takes muscles that push, joints accelerate a little.
    """
    q, dq = ([p[f"initial.{name}"] for name in system.joint(signal)] for signal in ("q", "dq"))
    at = [ca.SX.sym(joint) for joint in system.joints]
    lengths = ca.substitute(system.lengths(at, p), at, q)
    numbers = [p.part(muscle) for muscle in system.muscles]
    curves = [system.curves[muscle] for muscle in system.muscles]
    straight = [c.toe_force(n) for c, n in zip(curves, numbers, strict=True)]
    L_S = [c.Phi_S_inv(ca.SX(_GUESS * force), n) for c, n, force in zip(curves, numbers, straight, strict=True)]
    for _ in range(_ROUNDS):
        wanted, full = [], []
        for muscle, of, n, L_m, L in zip(system.muscles, curves, numbers, lengths, L_S, strict=True):
            # F = cos α (Φ_P + a f) at rest
            share, L_C, still = along_fibres(ca.SX(1), L_m, L, ca.SX(0), n)
            passive, most = (of.force(L_C, ca.SX(a), still, n) / share for a in (0, 1))
            full.append(most - passive)
            wanted.append(passive + p[f"initial.{system.name('a', muscle)}"] * full[-1])
        least = _LEAST * ca.vertcat(*straight)
        forces = _balanced(system, q, dq, ca.vertcat(*wanted), ca.vertcat(*full), least, p)
        L_S = [c.Phi_S_inv(force, n) for c, n, force in zip(curves, numbers, ca.vertsplit(forces), strict=True)]
    moving = zip((*system.joint("q"), *system.joint("dq")), (*q, *dq), strict=True)
    return Symbols({**dict(moving), **dict(zip(system.muscle("L_S"), L_S, strict=True))})


def _balanced(
    system: System, q: list[ca.SX], dq: list[ca.SX], wanted: ca.SX, full: ca.SX, least: ca.SX, p: Symbols
) -> ca.SX:
    """Forces (muscles × 1) near those wanted, as parts of the full ones, that pull and, if they can, balance."""
    F = ca.SX.sym("F", len(system.muscles))
    acc = ca.vertcat(*system.accelerations(q, dq, ca.vertsplit(F), p))
    # α(F) = G F + α₀;  F = F_w − W Gᵀ(G W Gᵀ)⁻¹ α(F_w),  W = diag(full²)
    G, W, still = ca.jacobian(acc, F), ca.diag(full**2), ca.substitute(acc, F, ca.SX.zeros(F.shape))

    def corrected(forces: ca.SX, weights: ca.SX) -> ca.SX:
        square = G @ weights @ G.T
        ridge = _RIDGE * (ca.trace(square) + 1) * ca.SX.eye(len(system.joints))
        return forces - weights @ G.T @ solved(square + ridge, G @ forces + still)

    forces = ca.fmax(wanted, least)
    for _ in range(_TURNS):
        # those that would have to push stay, and the others do what is left
        free = ca.diag(corrected(forces, W) > least)
        forces = ca.fmax(corrected(forces, free @ W), least)
    return forces
