"""The equation of motion of a tree, M(q) q̈ + h(q, q̇) = what pulls, by the recursion of Newton and Euler.

J. Y. S. Luh, M. W. Walker and R. P. C. Paul, On-line computational scheme for mechanical manipulators, Journal of
Dynamic Systems, Measurement, and Control 102, 1980. In the bodies' own frames, where inertias are constant.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ..arrays import Array
from .bodies import Body, bodies
from .frames import symbolic_about
from .tree import Tree


@dataclass(frozen=True, eq=False)
class Motion:
    """M (n × n) and h (n), where h holds the velocities', gravity's, springs' and dampers' part."""

    M: ca.SX
    h: ca.SX


def equation_of_motion(tree: Tree, q: Mapping[str, ca.SX], dq: Mapping[str, ca.SX]) -> Motion:
    """Of all coordinates of the tree, in its order; coordinates q and velocities dq by the joint's name."""
    names, chain = tree.coordinates, bodies(tree)
    ddq = {name: ca.SX.sym(f"dd_{name}") for name in names}
    found = _forces(chain, tree.gravity, q, dq, ddq)
    tau, accelerations = ca.vertcat(*(found[name] for name in names)), ca.vertcat(*ddq.values())
    # τ = M q̈ + c + g is linear in q̈
    M = ca.jacobian(tau, accelerations)
    h = ca.substitute(tau, accelerations, ca.SX.zeros(len(names)))
    # what a joint's spring and damper hold back
    passive = [
        joint.damping * dq[name] + joint.stiffness * (q[name] - joint.rest)
        for name in names
        for joint in [tree.joints[name]]
    ]
    return Motion(M, h + ca.vertcat(*passive))


def mass_matrix(tree: Tree, q: Mapping[str, float]) -> Array:
    """M (n × n) at the coordinates q, by the joint's name, in the tree's units."""
    still = {name: ca.SX(0) for name in tree.coordinates}
    motion = equation_of_motion(tree, {name: ca.SX(q[name]) for name in tree.coordinates}, still)
    return np.array(ca.evalf(ca.densify(motion.M)), dtype=float)


def _forces(
    chain: Sequence[Body],
    gravity: Sequence[float],
    q: Mapping[str, ca.SX],
    dq: Mapping[str, ca.SX],
    ddq: Mapping[str, ca.SX],
) -> dict[str, ca.SX]:
    """The force or torque of each joint that makes the accelerations ddq."""
    # Rᵀ, the place in the parent, ω, ω̇ and acceleration of each body, in its own frame
    inward: list[ca.SX] = []
    places: list[ca.SX] = []
    omega: list[ca.SX] = []
    omega_dot: list[ca.SX] = []
    acceleration: list[ca.SX] = []
    # a ground that accelerates upwards is gravity
    still = (ca.SX(3, 1), ca.SX(3, 1), -_column(np.array(gravity, dtype=float)))
    for body in chain:
        w_p, dw_p, a_p = still if body.parent < 0 else (v[body.parent] for v in (omega, omega_dot, acceleration))
        e, position, speed, rate = _column(body.axis), q[body.name], dq[body.name], ddq[body.name]
        turned, at = ca.SX(ca.sparsify(ca.DM(body.joint.turned))), _column(body.joint.at)
        if body.slides:
            at = at + turned @ (e * position)
        else:
            turned = turned @ symbolic_about(body.axis, position)
        Rt = turned.T
        carried = Rt @ w_p
        a = Rt @ (a_p + ca.cross(dw_p, at) + ca.cross(w_p, ca.cross(w_p, at)))
        if body.slides:
            # ω = Rᵀω_p,  a += e q̈ + 2 Rᵀω_p × e q̇
            w, dw, a = carried, Rt @ dw_p, a + e * rate + 2 * ca.cross(carried, e * speed)
        else:
            # ω = Rᵀω_p + e q̇,  ω̇ = Rᵀω̇_p + e q̈ + Rᵀω_p × e q̇
            w, dw = carried + e * speed, Rt @ dw_p + e * rate + ca.cross(carried, e * speed)
        for kept, value in zip((inward, places, omega, omega_dot, acceleration), (turned, at, w, dw, a), strict=True):
            kept.append(value)
    force = [ca.SX(3, 1) for _ in chain]
    moment = [ca.SX(3, 1) for _ in chain]
    tau: dict[str, ca.SX] = {}
    for number in reversed(range(len(chain))):
        body, w, dw = chain[number], omega[number], omega_dot[number]
        r, inertia = _column(body.com), ca.SX(ca.sparsify(ca.DM(body.inertia)))
        # f = m (a + ω̇ × r + ω × (ω × r)),  n = r × f + I ω̇ + ω × I ω
        f = body.mass * (acceleration[number] + ca.cross(dw, r) + ca.cross(w, ca.cross(w, r)))
        n = ca.cross(r, f) + inertia @ dw + ca.cross(w, inertia @ w)
        force[number] += f
        moment[number] += n
        e = _column(body.axis)
        # τ = e·n for a pin, e·f for a slider
        tau[body.name] = ca.dot(e, force[number] if body.slides else moment[number])
        if body.parent >= 0:
            out = inward[number] @ force[number]
            force[body.parent] += out
            moment[body.parent] += inward[number] @ moment[number] + ca.cross(places[number], out)
    return tau


def _column(vector: Array) -> ca.SX:
    return ca.SX(ca.sparsify(ca.DM(vector)))
