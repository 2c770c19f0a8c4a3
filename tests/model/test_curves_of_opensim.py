"""OpenSim's own numbers as an oracle of the curve sets that are its."""

from collections.abc import Mapping

import numpy as np
import pytest

from curve_values import NORMALISED, at, rows
from places import DATA

# F0 in N, l0 in m, vmax in l0/s of the muscle that is the unit, unlike any of those in the data
UNIT_F, UNIT_L, UNIT_V = 900.0, 0.11, 9.0


def in_pair_units(name: str, row: Mapping[str, float]) -> dict[str, float]:
    return {
        "F_max": row["F0"] / UNIT_F,
        "l_opt": row["l0"] / UNIT_L,
        "v_max": row["vmax"] / UNIT_V,
        "L_slack": row["lT"] / UNIT_L,
        **{key: row[key] for key in ("tendon_strain", "passive_strain", "damping")},
    }


@pytest.mark.parametrize("name", NORMALISED)
def test_any_muscle_is_as_in_OpenSim(name: str) -> None:
    """Muscles with numbers of their own, in the units of another: activation, velocity, force and length."""
    found = [
        {k: float(v) for k, v in row.items() if k != "curves"}
        for row in rows("curves_opensim.csv")
        if row["curves"] == name
    ]
    assert len(found) == 20
    limited = 0
    for row in found:
        own = in_pair_units(name, row)
        F, L_S, L_C = row["force"] / UNIT_F, row["tendon_length"] / UNIT_L, row["fibre_length"] / UNIT_L
        u = -row["fibre_velocity"] / (UNIT_L * UNIT_V)
        assert at(name, "activation", F, L_C, u, **own)[0] == pytest.approx(row["activation"], abs=1e-9)
        (moving,), (limit,) = (at(name, "velocity", F, L_C, row["activation"], order=k, **own) for k in (0, 1))
        # the others lengthen faster than the limit of the force factor lets them
        assert limit == 1 or moving == pytest.approx(u, abs=1e-9)
        limited += limit
        assert at(name, "Phi_S", L_S, **own)[0] == pytest.approx(F, abs=1e-12)
        assert at(name, "Phi_S_inv", F, **own)[0] == pytest.approx(L_S, abs=1e-12)
    assert limited <= 5


RECORDINGS = [
    ("dgf_smooth", "degroote_fregly2016", 0.049, 0.6),
    ("dgf_random", "degroote_fregly2016", 0.04, 0.6),
    ("millard_steps", "millard2012", 0.04, 0.7),
]


@pytest.mark.parametrize(("file", "name", "tendon", "passive"), RECORDINGS)
def test_the_activation_of_a_recording_follows_from_its_true_columns(
    file: str, name: str, tendon: float, passive: float
) -> None:
    table = np.genfromtxt(DATA / f"curves_{file}.csv", delimiter=",", names=True)
    assert len(table) >= 50
    own = {"tendon_strain": tendon, "passive_strain": passive}
    for j in (1, 2):
        F, L_C, L_S = (
            table[f"{n}_{j}"] / unit for n, unit in (("force", 1000), ("fibre_length", 0.1), ("tendon_length", 0.1))
        )
        u = -table[f"fibre_velocity_{j}"] / (0.1 * 10)
        np.testing.assert_allclose(
            at(name, "activation", F, L_C, u, **own), table[f"activation_{j}"], rtol=0, atol=1e-7
        )
        np.testing.assert_allclose(at(name, "Phi_S_inv", F, **own), L_S, rtol=0, atol=2e-8)


def test_Millards_curves_are_OpenSims_tables() -> None:
    places = {
        "tendon_force_length": ("Phi_S", 2.0),
        "passive_force_length": ("Phi_P", 1.0),
        "active_force_length": ("f", 1.0),
        "force_velocity": ("g", -1.0),
    }
    table = list(rows("curves_millard_tables.csv"))
    for curve, (ours, scale) in places.items():
        x, y = np.array([(float(r["x"]), float(r["y"])) for r in table if r["curve"] == curve]).T
        np.testing.assert_allclose(at("millard2012", ours, scale * x, tendon_strain=0.04), y, rtol=0, atol=1e-11)


def test_De_Groote_Freglys_curves_are_the_formulas_in_NumPy() -> None:
    x, name = np.linspace(0.3, 1.8, 301), "degroote_fregly2016"
    bells = ((0.8150671134243542, 1.055033428970575, 0.162384573599574, 0.063303448465465),
             (0.433004984392647, 0.71677541339776, -0.029947116970696, 0.200356847296188),
             (0.1, 1.0, 0.353553390593274, 0.0))  # fmt: skip
    f = sum(b1 * np.exp(-0.5 * ((x - b2) / (b3 + b4 * x)) ** 2) for b1, b2, b3, b4 in bells)
    np.testing.assert_allclose(at(name, "f", x), f, rtol=1e-13)
    least = np.exp(4 * (0.2 - 1) / 0.6)
    np.testing.assert_allclose(
        at(name, "Phi_P", x), (np.exp(4 * (x - 1) / 0.6) - least) / (np.exp(4) - least), rtol=1e-12
    )
    s = -8.149 * (x - 1) - 0.374
    g = -0.3211346127989808 * np.log(s + np.sqrt(s**2 + 1)) + 0.8825327733249912
    np.testing.assert_allclose(at(name, "g", 1 - x), g, rtol=1e-12, atol=1e-13)
    strained = 1 + (x - 1) * 0.1
    np.testing.assert_allclose(
        at(name, "Phi_S", 2 * strained), 0.2 * np.exp(36.566519780164434 * (strained - 1)) - 0.2, rtol=1e-11, atol=1e-13
    )
