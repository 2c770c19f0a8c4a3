"""The plant: two muscles on one mass, under the paper's names x₁…x₄, with one of three drives."""

from __future__ import annotations

import dataclasses

from .block import Block, BlockError
from .curves import NGUYEN2019, Curves, by_muscle, curve_parameters
from .muscle import ACTIVATION_LIMITS, activated_muscle, requested_activation, virtual_muscle
from .skeleton.load import mass
from .symbols import MUSCLES, STATES
from .wiring import many, rename, wire

DRIVES = {
    "virtual": "u from the controller, as the paper simulates",
    "requested": "the activation that the controller's u asks for, limited to [a_min, 1]",
    "given": "activations given as signals, without a controller",
}


def pair(drive: str = "virtual", curves: Curves = NGUYEN2019) -> Block:
    """The plant [load1]–[lsdot2]; inputs Delta and u1, u2 (drives virtual, requested) or a1, a2 (given).

    Outputs x1…x4, Phi_S1, Phi_S2, L_C1, L_C2, u1, u2, a1, a2, taut1, taut2; starts at the parameters x1_0 … x4_0.
    """
    if drive not in DRIVES:
        raise BlockError(f"unknown drive {drive!r}; valid: {', '.join(DRIVES)}")
    muscle = virtual_muscle if drive == "virtual" else activated_muscle
    port = "u" if drive == "virtual" else "a"
    outside = "a" if drive == "given" else "u"
    sets = by_muscle(curves)
    parts = [mass(), *(block for name in MUSCLES for block in many(muscle(sets[name]), [name]))]
    connections: dict[str, str | float] = {"mass.Delta": "Delta"}
    for j, name in enumerate(MUSCLES, start=1):
        connections |= {
            f"{name}.L_m": f"mass.{name}_L_m",
            f"{name}.dL_m": f"mass.{name}_dL_m",
            f"{name}.{port}": f"{outside}{j}",
            f"mass.{name}_F": f"{name}.Phi_S",
        }
        if drive == "requested":
            (request,) = many(requested_activation(sets[name]), [f"request{j}"])
            parts.append(request)
            connections |= {
                f"{name}.a": f"{request.name}.a",
                f"{request.name}.Phi_S": f"{name}.Phi_S",
                f"{request.name}.L_C": f"{name}.L_C",
                f"{request.name}.u": f"u{j}",
            }
    external = dict.fromkeys(("Delta", f"{outside}1", f"{outside}2"), "staged")
    return _as_in_the_paper(wire("plant", parts, connections, external), curves)


def _as_in_the_paper(wired: Block, curves: Curves) -> Block:
    """States, outputs and parameters under the names of the paper; curve numbers shared with all who use them."""
    sets = by_muscle(curves)
    names = {"mass.q": "x1", "mass.dq": "x2", "mass.q0": "x1_0", "mass.dq0": "x2_0", "mass.m": "m", "mass.C": "C"}
    for j, name in enumerate(MUSCLES, start=1):
        names |= {f"{name}.L_S": f"x{j + 2}", f"{name}.L_S0": f"x{j + 2}_0", f"{name}.L_C": f"L_C{j}"}
        names |= {f"{name}.{port}": f"{port}{j}" for port in ("Phi_S", "u", "a", "taut")}
        names |= {f"{name}.{limit}": limit for limit in ACTIVATION_LIMITS}
        names |= {f"{name}.{guard}": f"{guard[0]}{j}{guard[1:]}" for guard in ("a_limit", "a_infeasible", "z_limit")}
        names |= {f"request{j}.{key}": f"{name}.{key}" for key in sets[name].parameters}
    used = {*wired.x, *wired.y, *wired.p, *wired.guards, *wired.domain}
    outputs = [*STATES, *(f"{port}{j}" for port in ("Phi_S", "L_C", "u", "a", "taut") for j in (1, 2))]
    plant = rename(wired, "plant", {old: new for old, new in names.items() if old in used}, outputs)
    shared = {key: value for key, value in curve_parameters(curves).items() if key in plant.parameters}
    return dataclasses.replace(plant, parameters={**plant.parameters, **shared})
