"""Values and slopes of every curve set, by CasADi's virtual machine."""

import csv
from collections.abc import Iterator
from functools import cache

import casadi as ca
import numpy as np

from hillobs.model.block import symbols
from hillobs.model.curves import CURVES, SIMULATED
from hillobs.model.curves.tabulated import tabulated
from millard_tables import fine
from places import DATA

NORMALISED = tuple(name for name in SIMULATED if name != "nguyen2019")
# what stands in the registry, and one set that a user gave as tables
SETS = {**{name: CURVES[name] for name in SIMULATED}, "tables": tabulated(fine())}
CURVE_NAMES = ("Phi_S", "Phi_S_inv", "Phi_P", "f", "g", "g_inv")
# away from the paper's, and with an own unit
OTHER = {"F_max": 0.7, "l_opt": 1.2, "v_max": 0.8, "L_slack": 1.7, "damping": 0.05}


@cache
def functions(name: str) -> dict[str, ca.Function]:
    """Each curve with its derivative, and the two directions between activation and velocity."""
    curves, p = SETS[name], symbols(SETS[name].parameters)
    x, F, L, w = (ca.SX.sym(n) for n in ("x", "F", "L", "w"))
    result = {}
    for curve in CURVE_NAMES:
        value = getattr(curves, curve)(x, p)
        slope = ca.jacobian(value, x)
        result[curve] = ca.Function(curve, [x, p.vector()], [value, slope, ca.jacobian(slope, x)])
    result["activation"] = ca.Function("activation", [F, L, w, p.vector()], [curves.activation(F, L, w, p)])
    result["velocity"] = ca.Function("velocity", [F, L, w, p.vector()], [*curves.velocity(F, L, w, p, ca.SX(1.35))])
    return result


def numbers(name: str, **changed: float) -> dict[str, float]:
    known = {key: parameter.default for key, parameter in SETS[name].parameters.items()}
    return known | {key: value for key, value in changed.items() if key in known}


def at(name: str, curve: str, *arguments: object, order: int = 0, **changed: float) -> np.ndarray:
    """A curve, or its derivative of the order given, at each argument."""
    columns = [ca.DM(np.atleast_1d(np.asarray(x, dtype=float))).T for x in arguments]
    values = functions(name)[curve](*columns, ca.DM(list(numbers(name, **changed).values())))
    return np.array(values if isinstance(values, ca.DM) else values[order]).ravel()


def rows(file: str) -> Iterator[dict[str, str]]:
    with (DATA / file).open(newline="") as source:
        yield from csv.DictReader(source)


RANGES = {
    "Phi_S": (1.9, 2.2),
    "Phi_S_inv": (0.01, 1.0),
    "Phi_P": (0.5, 2.0),
    "f": (0.1, 2.0),
    "g": (-3.0, 0.9),
    "g_inv": (0.1, 1.3),
}
