"""Laws that hold for every curve set, and OpenSim's own numbers as an oracle."""

import csv
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from hillobs.codegen.library import compile_functions
from hillobs.model.block import symbols
from hillobs.model.curves import CURVES, NGUYEN2019_PRINTED, SIMULATED
from hillobs.model.curves.bezier import Knot, through
from hillobs.model.curves.tabulated import tabulated
from hillobs.studies.cli.main import commands
from hillobs.studies.figures.muscle_curves import curve_figure
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.scenarios.layers import Layer, layer
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.scenarios.scenario import choices, curves_of
from hillobs.studies.simulate.run import simulate
from millard_tables import fine
from places import DATA, contents

NORMALISED = tuple(name for name in SIMULATED if name != "nguyen2019")
# what stands in the registry, and one set that a user gave as tables
SETS = {**{name: CURVES[name] for name in SIMULATED}, "tables": tabulated(fine())}
CURVE_NAMES = ("Phi_S", "Phi_S_inv", "Phi_P", "f", "g", "g_inv")
# F0 in N, l0 in m, vmax in l0/s of the muscle that is the unit, unlike any of those in the data
UNIT_F, UNIT_L, UNIT_V = 900.0, 0.11, 9.0
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


every_set = pytest.mark.parametrize("name", SETS)
own_units = st.sampled_from([{}, OTHER])


@every_set
@settings(max_examples=40)
@given(forces=st.lists(st.floats(1e-9, 3.0), min_size=1, max_size=30), units=own_units)
def test_a_tendon_has_the_force_that_its_length_was_asked_for(
    name: str, forces: list[float], units: dict[str, float]
) -> None:
    lengths = at(name, "Phi_S_inv", forces, **units)
    np.testing.assert_allclose(at(name, "Phi_S", lengths, **units), forces, rtol=1e-12, atol=1e-13)


@every_set
@settings(max_examples=40)
@given(
    a=st.floats(0.01, 1.0),
    L_C=st.floats(0.6, 1.6),
    share=st.floats(0.02, 0.98),
    units=own_units,
)
def test_the_activation_is_the_one_that_gave_the_velocity(
    name: str, a: float, L_C: float, share: float, units: dict[str, float]
) -> None:
    """For any force between that of the fastest fibre and that of the limit z_max, damping included."""
    F = at(name, "Phi_P", L_C, **units) + share * 1.35 * a * at(name, "f", L_C, **units)
    u = at(name, "velocity", F, L_C, a, **units)
    assert at(name, "velocity", F, L_C, a, order=1, **units)[0] == 0
    assert at(name, "activation", F, L_C, u, **units)[0] == pytest.approx(a, rel=1e-9)


@every_set
@settings(max_examples=30)
@given(z=st.floats(0.0, 1.39), units=own_units)
def test_g_inverts_its_inverse(name: str, z: float, units: dict[str, float]) -> None:
    units = {**units, "damping": 0.0}
    assert at(name, "g", at(name, "g_inv", z, **units), **units)[0] == pytest.approx(z, abs=1e-12)


@every_set
@pytest.mark.parametrize("units", [{}, OTHER])
def test_curves_rise_and_fall_as_they_must(name: str, units: dict[str, float]) -> None:
    slack = numbers(name, **units)["L_slack"]
    lengths, fibres = np.linspace(0.8 * slack, 1.2 * slack, 3001), np.linspace(0.3, 2.2, 3001)
    assert (np.diff(at(name, "Phi_S", lengths, **units)) >= -1e-14).all()
    assert (np.diff(at(name, "Phi_S_inv", np.linspace(0, 3, 3001), **units)) > 0).all()
    assert (np.diff(at(name, "Phi_P", fibres, **units)) >= -1e-14).all()
    fastest = 1.2 * 0.8 if units else 1.0  # l_opt·v_max; Millard's damped fibre has no slope beyond
    assert (np.diff(at(name, "g", np.linspace(-0.98, 0.98, 3001) * fastest, **units)) < 0).all()
    assert (np.diff(at(name, "g", np.linspace(-4, 0.95, 3001), **units)) <= 1e-14).all()
    assert (np.diff(at(name, "g_inv", np.linspace(0, 1.39, 3001), **{**units, "damping": 0.0})) < 0).all()
    velocities = at(name, "velocity", np.linspace(0.1, 3, 3001), 1.1, 0.4, **units)
    assert (np.diff(velocities) <= 1e-14).all()


# where curves are joined, in lengths and velocities of a muscle whose units are the pair's, and how smooth they are
JOINTS = [
    ("nguyen2019", "Phi_S", (2.0, 2.04), 2),
    ("nguyen2019", "Phi_P", (1.0,), 2),
    ("nguyen2019", "g", (0.0,), 1),
    ("thelen2003", "Phi_S", (2 * (1 + 0.04 * 99 * np.exp(3) / (166 * np.exp(3) - 67)),), 1),
    ("thelen2003", "g", (0.0,), 0),
    ("thelen2003", "g", (1.0, -0.33 * 0.4 / (10 * 0.07)), 1),
    ("millard2012", "Phi_S", (2.0,), 2),
    ("millard2012", "Phi_P", (1.0, 1.035, 1.7), 2),
    ("millard2012", "f", (0.4441, 0.58705, 0.84, 1.0, 1.43115, 1.8123), 2),
    ("millard2012", "g", (-1.0, -0.9, 0.0, 0.9, 1.0), 2),
    ("degroote_fregly2016", "Phi_S", (2.0,), 2),
]


@pytest.mark.parametrize(("name", "curve", "joints", "order"), JOINTS)
def test_derivatives_agree_on_both_sides_of_a_joint(
    name: str, curve: str, joints: tuple[float, ...], order: int
) -> None:
    h = 1e-9
    spread = np.linspace(0.3, 2.2, 401) if curve in ("Phi_P", "f") else np.linspace(-1.2, 1.1, 401)
    spread = np.linspace(1.9, 2.1, 401) if curve == "Phi_S" else spread
    for derivative in range(order + 1):
        scale = np.abs(at(name, curve, spread, order=derivative)).max()
        for joint in joints:
            left, right = at(name, curve, [joint - h, joint + h], order=derivative)
            assert abs(left - right) <= 2e-5 * scale, (joint, derivative)
    if name == "thelen2003" and order < 2:
        # and no smoother, so that the table of docs/curves.md is right
        left, right = at(name, curve, [joints[-1] - h, joints[-1] + h], order=order + 1)
        assert abs(left - right) > 1e-2


RANGES = {
    "Phi_S": (1.9, 2.2),
    "Phi_S_inv": (0.01, 1.0),
    "Phi_P": (0.5, 2.0),
    "f": (0.1, 2.0),
    "g": (-3.0, 0.9),
    "g_inv": (0.1, 1.3),
}


@every_set
@pytest.mark.parametrize("curve", CURVE_NAMES)
def test_derivatives_are_those_of_finite_differences(name: str, curve: str) -> None:
    x, h = np.random.default_rng(1).uniform(*RANGES[curve], 300), 1e-6
    difference = (at(name, curve, x + h) - at(name, curve, x - h)) / (2 * h)
    np.testing.assert_allclose(at(name, curve, x, order=1), difference, rtol=2e-5, atol=2e-4)


@every_set
@pytest.mark.parametrize("units", [{}, OTHER])
def test_no_curve_is_ever_not_a_number(name: str, units: dict[str, float]) -> None:
    """Far out it may be infinite: where an exponential is, or at a pole."""
    far = [sign * value for sign in (1, -1) for value in (0.0, 1e-300, 1e-45, 1e-9, 0.5, 1.0, 2.0, 9.0, 1e3, 1e6)]
    knots = [joint for _, _, joints, _ in JOINTS for joint in joints]
    for curve in ("Phi_S", "Phi_S_inv", "Phi_P", "f", "g"):
        values = at(name, curve, [*far, *knots], **units)
        assert not np.isnan(values).any(), curve
        assert np.isfinite(values[np.abs([*far, *knots]) < 5]).all(), curve
        near = [x for x in (*far, *knots) if abs(x) < 5]
        assert np.isfinite(at(name, curve, near, order=1, **units)).all(), curve
    for force in (0.0, 1e-9, 1.0, 50.0, -5.0):
        velocities = at(name, "velocity", force, 0.9, [0.01, 1.0], **units)
        assert np.isfinite(velocities).all()
        for u in (-5.0, 0.0, 0.25, 0.95):
            assert np.isfinite(at(name, "activation", force, [0.1, 1.0, 3.0], u, **units)).all()
    infinite = at(name, "Phi_S_inv", [-np.inf, np.inf], **units)
    assert np.isfinite(infinite[0])
    assert infinite[1] == np.inf


@every_set
def test_a_force_too_low_gives_the_shortest_length(name: str) -> None:
    low, lower = at(name, "Phi_S_inv", [-1.0, -50.0])
    assert low == lower
    if name == "degroote_fregly2016":  # this tendon pushes, but never with 0.2
        assert low < 2.0
        assert at(name, "Phi_S_inv", -0.19)[0] > low
        assert at(name, "Phi_S", 1.0)[0] > -0.2
    else:
        assert low == pytest.approx(2.0, abs=1e-14)
        assert at(name, "Phi_S", 1.9)[0] == 0.0


def test_passive_force_is_there_below_the_optimal_length_where_the_publication_says_so() -> None:
    passive = {name: at(name, "Phi_P", 0.9)[0] for name in SIMULATED}
    assert passive.pop("degroote_fregly2016") > 0.005
    assert set(passive.values()) == {0.0}


def test_a_tendon_has_its_strain_at_F_max() -> None:
    for name in NORMALISED:
        stretched = at(name, "Phi_S", 1.7 * 1.05, **{**OTHER, "tendon_strain": 0.05})
        assert stretched[0] == pytest.approx(0.7, rel=1e-12), name
        passive = at(name, "Phi_P", 1.2 * 1.65, **{**OTHER, "passive_strain": 0.65})
        assert passive[0] == pytest.approx(0.7, rel=1e-12), name


# ---------------------------------------------------------------- OpenSim


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


# ---------------------------------------------------------------- as machine code, and in the pair


@pytest.mark.numerics
def test_compiled_they_are_what_the_virtual_machine_computes() -> None:
    table, arguments = {}, {}
    rng = np.random.default_rng(7)
    for name, curves in SETS.items():
        p = symbols(curves.parameters)
        values = list(numbers(name, **OTHER).values())
        x, F, L, w = (ca.SX.sym(n) for n in ("x", "F", "L", "w"))
        for curve, (low, high) in RANGES.items():
            f = ca.Function(f"{name}_{curve}", [x, p.vector()], [ca.densify(getattr(curves, curve)(x, p))])
            table[f.name()], arguments[f.name()] = f, (rng.uniform(low, high, (64, 1)), values)
        drawn = [rng.uniform(low, high, (64, 1)) for low, high in ((0.0, 1.5), (0.5, 1.6), (0.05, 0.9))]
        for what, result in (
            ("activation", [curves.activation(F, L, w, p)]),
            ("velocity", curves.velocity(F, L, w, p, ca.SX(1.35))[:1]),
        ):
            f = ca.Function(f"{name}_{what}", [F, L, w, p.vector()], result)
            table[f.name()], arguments[f.name()] = f, (*drawn, values)
    library = compile_functions(list(table.values()))
    for key, f in table.items():
        *columns, values = arguments[key]
        (compiled,) = library.call(key, *columns, values)
        machine = np.array(f(*(ca.DM(column).T for column in columns), ca.DM(values))).T
        np.testing.assert_allclose(compiled, machine, rtol=1e-9, atol=1e-12, err_msg=key)


@pytest.mark.numerics
def test_two_unlike_muscles_pull_one_mass() -> None:
    """Each by its own curves and numbers: its force and its activation follow from what the run recorded."""
    own = {
        "muscle2.F_max": 0.7,
        "muscle2.l_opt": 0.9,
        "muscle2.v_max": 1.3,
        "muscle2.L_slack": 2.1,
        "muscle1.damping": 0.1,
    }
    changes = {"muscle1.curves": "degroote_fregly2016", "muscle2.curves": "thelen2003", **own}
    start = {"initial.x1": 2.8, "initial.x3": 2.03, "initial.x4": 2.13, "plant.C": 5.8}
    run = simulate("activation", ["high_gain"], {**changes, **start, "duration": 0.5, "step": 1e-3})
    assert run.attrs["failures"] == "{}"
    assert '"muscle2.curves": "thelen2003"' in run.attrs["choices"]
    x1, _, x3, x4 = run.x.values.T
    for j, (name, L_S, L_C) in enumerate((("degroote_fregly2016", x3, x1 - x3), ("thelen2003", x4, 5.8 - x1 - x4)), 1):
        numbers_of = {key.partition(".")[2]: value for key, value in own.items() if key.startswith(f"muscle{j}.")}
        force = at(name, "Phi_S", L_S, **numbers_of)
        u, a = run.u.sel(muscle=j).values, run.a.sel(muscle=j).values
        assert np.ptp(a) > 0.04
        np.testing.assert_allclose(at(name, "activation", force, L_C, u, **numbers_of), a, rtol=1e-8)
        assert np.abs(u).max() > 0.01


def test_a_scenario_names_the_curves_of_each_muscle() -> None:
    file = layer("my.toml", {"muscle": {"curves": "thelen2003"}, "muscle1": {"curves": "millard2012"}})
    assert choices([file, Layer("", {"muscle2.curves": "nguyen2019"})]) == {
        "muscle1.curves": "millard2012",
        "muscle2.curves": "nguyen2019",
    }
    # a command line wins over a file, a group too
    assert set(choices([file, Layer("", {"muscle.curves": "thelen2003"})]).values()) == {"thelen2003"}
    assert curves_of({}) is CURVES["nguyen2019"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"muscle.curves": NGUYEN2019_PRINTED.name}, "muscle.curves must be one of nguyen2019, degroote_fregly2016"),
        ({"muscle2.curves": 3.0}, "muscle2.curves must be one of .*, not 3"),
        ({"muscle.curves": "thelen2003", "muscle.k": 20.0}, "unknown path 'muscle.k'"),
        ({"muscle1.curves": "thelen2003", "muscle2.k": 99.0}, "muscle2: k·toe"),
        ({"muscle.curves": "thelen2003", "muscle2.F_len": 1.0}, "muscle2.F_len must be above 1.05"),
        ({"muscle.curves": "millard2012", "muscle.damping": -1.0}, "muscle.damping must be at least 0"),
    ],
)
def test_what_is_wrong_with_curves_is_said(changes: dict[str, str | float], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        prepare("activation", None, changes)


@settings(max_examples=25)
@given(
    slopes=st.tuples(st.floats(0.1, 0.4), st.floats(0.6, 0.95), st.floats(1.3, 4.0)),
    curviness=st.floats(0.0, 1.0),
    x=st.floats(-1.0, 4.0),
)
def test_a_bezier_curve_rises_and_its_inverse_finds_back(
    slopes: tuple[float, float, float], curviness: float, x: float
) -> None:
    knots = [Knot(0.0, 0.0, slopes[0]), Knot(1.0, 0.5, slopes[1]), Knot(2.0, 1.6, slopes[2])]
    curve, s = through(knots, [curviness] * 2), ca.SX.sym("s")
    f = ca.Function("f", [s], [curve(s), curve.inverse(curve(s)), ca.jacobian(curve(s), s)])
    _, back, slope = (float(v) for v in f(x))
    assert back == pytest.approx(x, abs=1e-9)
    assert slope > 0


def test_every_set_is_drawn_and_listed(tmp_path: Path) -> None:
    ran = CliRunner().invoke(commands, ["curves", "--out", str(tmp_path)])
    assert ran.exit_code == 0, ran.output
    assert sorted(contents(tmp_path)) == ["curves-sets.pdf", "curves-sets.png"]
    figure = curve_figure()
    for axes in figure.axes:
        assert len(axes.lines) == len(SIMULATED)
        assert all(np.isfinite(np.asarray(line.get_ydata(), dtype=float)).all() for line in axes.lines)
    listed = CliRunner().invoke(commands, ["list", "curves"]).output
    assert all(f"{name} " in listed for name in CURVES)
    assert "tendon_strain 0.049" in listed
