"""Tables of Millard's curves: OpenSim's, every 13th point, and the same ranges as finely as OpenSim's own."""

import csv
from functools import cache

import casadi as ca
import numpy as np

from hillobs.model.block import symbols
from hillobs.model.curves import MILLARD2012
from hillobs.model.curves.tabulated import TABLES, Tables
from places import DATA

EXCERPT = DATA / "curves_millard_tables.csv"
# first, last and number of points; our curve, and what makes own units of the pair's
GRIDS = {
    "tendon_force_length": (0.99, 1.07, 1601, "Phi_S", 2.0),
    "passive_force_length": (0.3, 1.9, 1601, "Phi_P", 1.0),
    "active_force_length": (0.3, 1.9, 1601, "f", 1.0),
    "force_velocity": (-1.2, 1.2, 2401, "g", -1.0),
}


@cache
def excerpt() -> Tables:
    with EXCERPT.open(newline="") as file:
        rows = [*csv.DictReader(file)]
    return Tables(
        **{name: tuple((float(r["x"]), float(r["y"])) for r in rows if r["curve"] == name) for name in TABLES}
    )


@cache
def fine() -> Tables:
    p, x = symbols(MILLARD2012.parameters), ca.SX.sym("x")
    values = {key: number.default for key, number in MILLARD2012.parameters.items()} | {"tendon_strain": 0.04}
    tables = {}
    for name, (first, last, count, curve, scale) in GRIDS.items():
        f = ca.Function("f", [x, p.vector()], [getattr(MILLARD2012, curve)(x, p)])
        places = np.round(np.linspace(first, last, count), 6)
        y = np.array(f(ca.DM(scale * places).T, ca.DM([*values.values()]))).ravel()
        tables[name] = tuple(zip(places.tolist(), y.tolist(), strict=True))
    return Tables(**tables)
