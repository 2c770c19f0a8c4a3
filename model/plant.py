"""The plant: joints that muscles move, with one of three drives. The paper's pair is one, under the paper's names."""

from __future__ import annotations

import dataclasses

from .block import Block, BlockError, Parameter, Parameters, Symbols, symbols
from .muscle import activated_muscle, requested_activation, virtual_muscle
from .system import PAIR, System
from .wiring import many, rename, wire

DRIVES = {
    "virtual": "u from the controller, as the paper simulates",
    "requested": "the activation that the controller's u asks for, limited to [a_min, 1]",
    "given": "activations given as signals, without a controller",
}
# what a muscle tells, in this order
_TOLD = ("Phi_S", "L_C", "u", "a", "taut")
STIFFNESS = "stiffness"
_GUARDS = ("a_limit", "a_infeasible", "z_limit")
_START = "chosen, docs/model.md#start"
_AT_START = {"q": (2.6, "position"), "dq": (0.0, "velocity")}


def skeleton(system: System = PAIR) -> Block:
    """What the muscles pull. Inputs F of each muscle and Delta of each joint; outputs q, dq of joints, L_m, dL_m."""
    x = symbols(f"{signal}.{joint}" for joint in system.joints for signal in _AT_START)
    u = symbols([*(f"F.{muscle}" for muscle in system.muscles), *(f"Delta.{joint}" for joint in system.joints)])
    starts: Parameters = {
        f"{signal}0.{joint}": Parameter(value, f"{words} at the start", _START)
        for joint in system.joints
        for signal, (value, words) in _AT_START.items()
    }
    parameters = {**system.parameters, **starts}
    p = symbols(parameters)
    q, dq = ([x[f"{signal}.{joint}"] for joint in system.joints] for signal in _AT_START)
    # q̈ = M⁻¹(R F − h) + Δ   [load1], [load2]
    acc = system.accelerations(q, dq, [u[f"F.{muscle}"] for muscle in system.muscles], p)
    lengths, rates = system.lengths(q, p), system.rates(q, dq, p)
    dx = Symbols()
    for joint, a in zip(system.joints, acc, strict=True):
        dx |= {f"q.{joint}": x[f"dq.{joint}"], f"dq.{joint}": a + u[f"Delta.{joint}"]}
    y = {
        **x,
        **{f"L_m.{muscle}": L for muscle, L in zip(system.muscles, lengths, strict=True)},
        **{f"dL_m.{muscle}": rate for muscle, rate in zip(system.muscles, rates, strict=True)},
    }
    x0 = Symbols({name: p[name.replace(".", "0.", 1)] for name in x})
    return Block("skeleton", x=x, u=u, p=p, parameters=parameters, dx=dx, x0=x0, y=Symbols(y))


def plant(system: System = PAIR, drive: str = "virtual") -> Block:
    """The plant, the pair's [load1]–[lsdot2]; inputs Delta of each joint and u or a of each muscle, by their names.

    Takes u with the drives virtual and requested, a if it is given. Outputs the states, then Phi_S, L_C, u, a and taut
    of all muscles; starts at the parameters x1_0 and so on.
    """
    if drive not in DRIVES:
        raise BlockError(f"unknown drive {drive!r}; valid: {', '.join(DRIVES)}")
    muscle = virtual_muscle if drive == "virtual" else activated_muscle
    port = "u" if drive == "virtual" else "a"
    outside = "a" if drive == "given" else "u"
    parts = [skeleton(system)]
    names = {f"skeleton.{key}": key for key in system.parameters}
    connections: dict[str, str | float] = {}
    for joint in system.joints:
        connections[f"skeleton.Delta.{joint}"] = system.name("Delta", joint)
        for signal in _AT_START:
            state = system.name(signal, joint)
            names |= {f"skeleton.{signal}.{joint}": state, f"skeleton.{signal}0.{joint}": f"{state}_0"}
    for i, of in enumerate(system.muscles):
        curves, oblique = system.curves[of], of in system.pennate
        (part,) = many(muscle(curves, oblique), [f"muscle{i}"])
        parts.append(part)
        drive_of = system.name(outside, of)
        connections |= {
            f"{part.name}.L_m": f"skeleton.L_m.{of}",
            f"{part.name}.dL_m": f"skeleton.dL_m.{of}",
            f"{part.name}.{port}": drive_of,
            f"skeleton.F.{of}": f"{part.name}.Phi_S",
        }
        state = system.name("L_S", of)
        names |= {f"{part.name}.{key}": f"{of}.{key}" for key in part.p}
        names |= {f"{part.name}.L_S": state, f"{part.name}.L_S0": f"{state}_0"}
        names |= {f"{part.name}.{signal}": system.name(signal, of) for signal in part.y if signal != "L_S"}
        names |= {f"{part.name}.{guard}": system.name(guard, of) for guard in _GUARDS if guard in part.guards}
        if drive == "requested":
            (request,) = many(requested_activation(curves, oblique), [f"request{i}"])
            parts.append(request)
            told = {"L_m": f"skeleton.L_m.{of}", "L_S": f"{part.name}.L_S", "u": drive_of}
            connections |= {f"{request.name}.{key}": source for key, source in told.items()}
            connections[f"{part.name}.a"] = f"{request.name}.a"
            names |= {f"{request.name}.{key}": f"{of}.{key}" for key in request.p}
    inputs = [*system.joint("Delta"), *system.muscle(outside)]
    wired = wire("plant", parts, connections, dict.fromkeys(inputs, "staged"))
    # a pair's muscles are resolved by any step that its observers take
    stiff = (STIFFNESS,) if drive != "virtual" and not system.paper else ()
    outputs = [*system.states, *(name for signal in (*_TOLD, *stiff) for name in system.muscle(signal))]
    whole = rename(wired, "plant", names, outputs)
    # numbers of curves are shared with all who use them
    shared = {key: value for key, value in system.curve_parameters.items() if key in whole.parameters}
    return dataclasses.replace(whole, parameters={**whole.parameters, **shared})
