"""Curves given as tables: smooth, rising, inverted, as close as they say; what makes no curve is refused."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from few_observers import few_observers
from hillobs.model.block import symbols
from hillobs.model.curves import CURVES, DEGROOTE_FREGLY2016, MILLARD2012, CurveSet
from hillobs.model.curves.fit import Fit, TableError, fit, invertible
from hillobs.model.curves.spline import MOST_STEPS, Spline
from hillobs.model.curves.tabulated import TABLES, Points, Tables, tabulated
from hillobs.studies.cli.main import commands
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.curves import read_curves
from hillobs.studies.laboratory.muscles import read_muscles
from millard_tables import EXCERPT, GRIDS, excerpt, fine
from places import DATA, RECORDINGS


def values(curves: CurveSet, curve: str, *arguments: object, **changed: float) -> np.ndarray:
    p, x = symbols(curves.parameters), [ca.SX.sym("x") for _ in arguments]
    numbers = {key: changed.get(key, parameter.default) for key, parameter in curves.parameters.items()}
    f = ca.Function("f", [*x, p.vector()], [getattr(curves, curve)(*x, p)])
    columns = [ca.DM(np.atleast_1d(np.asarray(argument, dtype=float))).T for argument in arguments]
    return np.array(f(*columns, ca.DM([*numbers.values()]))).ravel()


def derivatives(curve: Spline, x: np.ndarray) -> np.ndarray:
    """Value, slope and curvature (3 × n)."""
    s = ca.SX.sym("s")
    y = curve(s)
    slope = ca.jacobian(y, s)
    f = ca.Function("f", [s], [ca.vertcat(y, slope, ca.jacobian(slope, s))])
    return np.array(f(ca.DM(x).T))


def there_and_back(curve: Spline, x: np.ndarray, beta: float) -> tuple[np.ndarray, np.ndarray]:
    """y(x) + βx, and what the inverse makes of it put in again."""
    s, b = ca.SX.sym("s"), ca.SX.sym("b")
    sheared = ca.Function("sheared", [s, b], [curve(s) + b * s])
    y = sheared(ca.DM(x).T, beta)
    back = ca.Function("back", [s, b], [curve.inverse(s, b if beta else 0.0)])(y, beta)
    return np.array(y).ravel(), np.array(sheared(back, beta)).ravel()


# ---------------------------------------------------------------- Millard's, as tables


@pytest.mark.parametrize(("tables", "error"), [(fine(), 2.1e-6), (excerpt(), 2e-3)])
def test_Millards_tables_give_Millards_curves(tables: Tables, error: float) -> None:
    """At the points, within what the set says of itself; between them too, as far as they are close together."""
    curves, rng = tabulated(tables), np.random.default_rng(3)
    said = [float(text) for text in re.findall(r"\de-\d+", curves.sentence)]
    for name, said_error in zip(GRIDS, said, strict=True):
        first, last, _, curve, scale = GRIDS[name]
        x, y = np.array(getattr(tables, name)).T
        assert np.abs(values(curves, curve, scale * x) - y).max() <= 1.5 * said_error < 4e-6
        between = scale * rng.uniform(first, last, 3000)
        found = values(curves, curve, between) - values(MILLARD2012, curve, between, tendon_strain=0.04)
        assert np.abs(found).max() < error


@pytest.mark.parametrize(("tables", "error"), [(fine(), 1e-5), (excerpt(), 3e-4)])
def test_the_activation_of_a_recording_follows_from_tables(tables: Tables, error: float) -> None:
    table = np.genfromtxt(DATA / "curves_millard_steps.csv", delimiter=",", names=True)
    curves = tabulated(tables)
    for j in (1, 2):
        F, L_C, L_S = (
            table[f"{n}_{j}"] / unit for n, unit in (("force", 1000), ("fibre_length", 0.1), ("tendon_length", 0.1))
        )
        a = values(curves, "activation", F, L_C, -table[f"fibre_velocity_{j}"])
        np.testing.assert_allclose(a, table[f"activation_{j}"], rtol=0, atol=error)
        np.testing.assert_allclose(values(curves, "Phi_S_inv", F), L_S, rtol=0, atol=4e-7)


# ---------------------------------------------------------------- any table


def broken_line(*points: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.array(points).T
    return x, y


FITS = {
    **{
        name: fit(*np.array(getattr(fine(), name)).T, rising=name != "active_force_length", foot=name[0] in "tp")
        for name in TABLES
    },
    "corners": fit(*broken_line((0, 0), (1, 0), (2, 0.01), (3, 3), (4, 3.01), (5, 9)), rising=True, foot=True),
    "no foot": fit(*broken_line((-1, 0), (-0.5, 0.2), (0, 1), (0.5, 1.3), (1, 1.4)), rising=True),
}


@pytest.mark.parametrize("name", FITS)
def test_value_slope_and_curvature_agree_on_both_sides_of_every_node(name: str) -> None:
    curve = FITS[name].curve
    x = np.array([node.x for node in curve.nodes])
    h = 1e-10 * (x[-1] - x[0])
    sides = derivatives(curve, x - h), derivatives(curve, x + h)
    largest = np.abs(derivatives(curve, np.linspace(x[0], x[-1], 4001))).max(axis=1)
    assert (np.abs(sides[0] - sides[1]).max(axis=1) <= 1e-5 * largest).all()
    outside = derivatives(curve, np.array([x[0] - 1, x[-1] + 1]))
    assert (np.abs(outside[2]) == 0).all(), "straight beyond the ends"


tables_that_rise = st.lists(st.tuples(st.floats(0.02, 1.0), st.floats(-4, 0)), min_size=4, max_size=12).map(
    lambda steps: np.cumsum([(dx, 10**e) for dx, e in steps], axis=0).T
)


@settings(max_examples=15)
@given(table=tables_that_rise, foot=st.booleans(), beta=st.sampled_from([0.0, 0.05, 3.0]))
def test_a_table_that_rises_gives_a_curve_that_rises_and_an_inverse_that_finds_back(
    table: np.ndarray, foot: bool, beta: float
) -> None:
    """Corners and all: from step to step a table may be ten thousand times steeper."""
    x, y = table
    curve = invertible(fit(x, y, rising=True, foot=foot)).curve
    np.testing.assert_allclose(derivatives(curve, x)[0], y, rtol=0, atol=2e-6 * y.max())
    places = np.linspace(x[0] - 0.3 * (not foot), x[-1] + 0.5, 1001)
    found, slopes, _ = derivatives(curve, places)
    assert (slopes >= -1e-13 * slopes.max()).all()
    assert (np.diff(found) > -1e-14 * y.max()).all()
    wanted, back = there_and_back(curve, places, beta)
    np.testing.assert_allclose(back, wanted, rtol=1e-12, atol=1e-13 * np.abs(wanted).max())


def test_the_inverse_finds_back_to_1e_12_and_stays_inside() -> None:
    for name in ("tendon_force_length", "force_velocity"):
        curve = invertible(FITS[name]).curve
        assert curve.steps < MOST_STEPS
        x, y = np.linspace(curve.nodes[0].x, curve.nodes[-1].x, 20001), ca.SX.sym("y")
        inverse = ca.Function("inverse", [y], [curve.inverse(y)])
        back = np.array(inverse(ca.DM(derivatives(curve, x)[0]).T)).ravel()
        np.testing.assert_allclose(back, x, rtol=0, atol=1e-12)
        assert (np.diff(back) > 0).all()


def test_fewer_nodes_than_points_and_the_error_is_told() -> None:
    for name in TABLES:
        found, (x, y) = FITS[name], np.array(getattr(fine(), name)).T
        assert len(found.curve.nodes) < 45
        off = np.abs(derivatives(found.curve, x)[0] - y).max()
        assert off <= found.error + 1e-15
        assert found.error <= 1e-6 * y.max()


def test_a_rough_table_is_followed_less_closely_or_refused() -> None:
    x, rng = np.linspace(0, 1, 400), np.random.default_rng(0)
    smooth = np.sin(3 * x)
    waves: Fit = fit(x, smooth + 3e-5 * np.sin(300 * x))
    assert 1e-6 < waves.error <= 1e-4
    with pytest.raises(TableError, match="too rough; smooth it"):
        fit(x, smooth + 0.05 * rng.standard_normal(400))


def test_a_tendon_is_slack_before_its_table_and_passive_force_does_not_fall() -> None:
    curves = tabulated(fine())
    assert values(curves, "Phi_S", [0.0, 1.9, 2.0]).tolist() == [0, 0, 0]
    assert values(curves, "Phi_S_inv", [-5.0, 0.0]).tolist() == [2, 2]
    assert values(curves, "Phi_P", [0.0, 0.9]).tolist() == [0, 0]
    without = replace(fine(), passive_force_length=((0.5, 0.0), (1.0, 0.0), (1.5, 0.0), (1.6, 0.0)))
    assert values(tabulated(without), "Phi_P", [0.1, 1.0, 3.0]).tolist() == [0, 0, 0]
    # beyond the table with its last slope
    ends = values(curves, "Phi_S", [2.14, 2.2, 2.26])
    assert ends[2] - ends[1] == pytest.approx(ends[1] - ends[0], rel=1e-12)


# ---------------------------------------------------------------- what makes no curve


def with_points(name: str, change: Callable[[list[tuple[float, float]]], object]) -> Tables:
    points = [*getattr(excerpt(), name)]
    change(points)
    return replace(excerpt(), **{name: tuple(points)})


def at(index: int, x: float | None = None, y: float | None = None) -> Callable[[list[tuple[float, float]]], object]:
    def change(points: list[tuple[float, float]]) -> None:
        old = points[index]
        points[index] = (old[0] if x is None else x, old[1] if y is None else y)

    return change


def scaled(x: float, y: float, shift: float = 0.0) -> Callable[[list[tuple[float, float]]], object]:
    def change(points: list[tuple[float, float]]) -> None:
        points[:] = [(x * a + shift, y * b) for a, b in points]

    return change


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("force_velocity", at(40, y=-1.0), r"force_velocity: y must rise .* point 41 \(x = -0.68\) has -1 after"),
        ("force_velocity", scaled(1, -1), "y must rise"),
        ("force_velocity", scaled(10, 1), "factor must be 0 at the velocity -1"),
        ("force_velocity", scaled(1, 9), "factor must be 1 at the velocity 0, and is 9"),
        ("tendon_force_length", scaled(1, 1000), r"point 21, \(.*\), must be two numbers within ±20: tables are in"),
        ("active_force_length", lambda points: points.insert(60, (points[59][0] + 1e-6, 1.0)), "step from .* to 1 at"),
        ("force_velocity", lambda points: points.__delitem__(slice(0, 30)), "must reach from −1"),
        ("tendon_force_length", at(60, y=0.0), "y must rise .* point 61"),
        ("tendon_force_length", scaled(1, 0), "y must rise"),
        ("tendon_force_length", at(0, y=0.1), "must begin with force 0"),
        ("tendon_force_length", scaled(1, 1, -1), "the force begins at .* and must at 1"),
        ("passive_force_length", at(100, y=0.0), "y must never fall"),
        ("passive_force_length", scaled(1, -1), "never fall"),
        ("active_force_length", scaled(0.1, 1), "largest factor must be 1 at the length 1, and is .* at 0.1"),
        ("active_force_length", at(3, y=-0.2), "must not be below 0; point 4 is -0.2"),
        ("active_force_length", at(3, y=float("nan")), r"point 4, \(0.339, nan\), must be two numbers"),
        ("active_force_length", at(3, x=float("inf")), "point 4, .*inf, 0.1"),
        ("active_force_length", at(5, x=0.352), "x must rise .* point 6 has 0.352 after 0.352"),
        ("active_force_length", lambda points: points.__delitem__(slice(3, None)), "has 3 points; a curve needs 4"),
        ("active_force_length", lambda points: points.extend(points * 100), "points; a curve needs 4 to 5,000"),
    ],
)
def test_a_table_that_makes_no_curve_is_refused(
    name: str, change: Callable[[list[tuple[float, float]]], object], message: str
) -> None:
    with pytest.raises(TableError, match=message):
        tabulated(with_points(name, change))


# ---------------------------------------------------------------- files


def csv_of(tables: Tables) -> str:
    return "curve,x,y\n" + "".join(f"{name},{x!r},{y!r}\n" for name in TABLES for x, y in getattr(tables, name))


def test_equal_points_are_one_set_whatever_the_file(tmp_path: Path) -> None:
    plain = read_curves(EXCERPT)
    (tmp_path / "a.csv").write_text("\ufeff# measured\n\n" + csv_of(excerpt()).replace(",", ";").replace("\n", "\r\n"))
    assert read_curves(tmp_path / "a.csv") is plain is tabulated(excerpt())
    other = with_points("active_force_length", at(3, y=0.11))
    assert tabulated(other) is not plain
    assert tabulated(other).name != plain.name


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("curve,x,y", "x,y,curve", "row 1: its columns must be curve, x, y, not 'x, y, curve'"),
        ("curve,x,y\n", "", "row 1: its columns must be"),
        (
            "tendon_force_length,0.99,0.0",
            "tendon_force_lenght,0.99,0.0",
            "row 2: .* the nearest is tendon_force_length",
        ),
        ("tendon_force_length,0.99,0.0", "fish,0.99,0.0", "row 2: unknown curve 'fish'; there are tendon_force"),
        ("0.99065,0.0", "0.99065,zero", "row 3, column y: 'zero' is no number"),
        ("0.99065,0.0", "nan,0.0", "row 3, column x: 'nan' is no number"),
        ("0.99065,0.0", "0.99065", "row 3 has 2 cells for the columns"),
        ("0.99065,0.0", '"0.99065,0.0', "row 3: a quoted cell does not end"),
        ("0.99065,0.0", "1e999,0.0", "tendon_force_length: point 2, .*inf, 0.* must be two numbers"),
        ("0.99065,0.0", "0.98,0.0", "tendon_force_length: x must rise"),
        ("force_velocity", "#", "has no points of force_velocity"),
    ],
)
def test_a_file_says_what_is_wrong_with_it(tmp_path: Path, old: str, new: str, message: str) -> None:
    path, text = tmp_path / "c.csv", EXCERPT.read_text()
    path.write_text(text.replace(old, new) if new == "#" else text.replace(old, new, 1))
    with pytest.raises(ScenarioError, match=f"c.csv: {message}"):
        read_curves(path)


def muscle_file(folder: Path, curves: str, more: str = "") -> Path:
    lines = (RECORDINGS / "dgf_random.toml").read_text().splitlines()
    text = "\n".join(line for line in lines if not line.startswith(("tendon_strain", "passive_strain")))
    path = folder / "muscles.toml"
    path.write_text(text.replace('"degroote_fregly2016"', f'"{curves}"') + more)
    return path


def test_a_muscle_file_names_curves_beside_it(tmp_path: Path) -> None:
    (tmp_path / "own.csv").write_text(csv_of(excerpt()))
    pair = read_muscles(muscle_file(tmp_path, "own.csv"))
    assert pair.curves is tabulated(excerpt())
    assert pair.muscle1.numbers == {"damping": 0.0}
    pair = read_muscles(muscle_file(tmp_path, "own.csv", "\n[muscle2]\ncurves = 'thelen2003'\ntendon_strain = 0.05\n"))
    assert pair.curves == (tabulated(excerpt()), CURVES["thelen2003"])
    for curves, more, message in (
        ("none.csv", "", "muscle.curves: .*none.csv: cannot be read: No such file"),
        ("own.cvs", "", "muscle.curves must be one of .*, or a .csv file, not 'own.cvs'"),
        ("own.csv", "\ntendon_strain = 0.05\n", "unknown key 'muscle.tendon_strain'"),
    ):
        with pytest.raises(ScenarioError, match=message):
            read_muscles(muscle_file(tmp_path, curves, more))


def tables_of(curves: CurveSet) -> Tables:
    """A set's own curves as tables; its tendon only as far as it pulls."""

    def points(curve: str, scale: float, first: float, last: float, **changed: float) -> Points:
        x = np.linspace(first, last, 801)
        y = values(curves, curve, scale * x, **changed)
        return tuple(zip(x.tolist(), np.where(np.abs(y) < 1e-12, 0.0, y).tolist(), strict=True))

    return Tables(
        points("Phi_S", 2.0, 1.0, 1.06, tendon_strain=0.04),
        points("Phi_P", 1.0, 0.3, 1.8),
        points("f", 1.0, 0.3, 1.8),
        points("g", -1.0, -1.1, 1.1),
    )


@pytest.mark.numerics
def test_a_recording_is_estimated_with_a_table_of_curves(tmp_path: Path) -> None:
    """What the same curves under their own name give."""
    (tmp_path / "own.csv").write_text(csv_of(tables_of(DEGROOTE_FREGLY2016)))
    found = []
    for i, muscles in enumerate((RECORDINGS / "dgf_random.toml", muscle_file(tmp_path, "own.csv"))):
        out = tmp_path / str(i)
        arguments = ["estimate", DATA / "gains_dgf_random_noisy.csv", "--muscles", muscles, "--observer", "high_gain"]
        with few_observers("high_gain"):
            ran = CliRunner().invoke(commands, [*map(str, arguments), "--out", str(out), "--no-figures"])
        assert ran.exit_code == 0, ran.output
        with xr.open_dataset(out / "estimates.nc", engine="h5netcdf") as dataset:
            found.append(dataset.load())
    assert re.search(r"tables@[0-9a-f]{12}: \d+ pieces through 3,204 points of four tables; largest", ran.output)
    assert json.loads(found[1].attrs["curves"])[0].startswith("tables@")
    named, own = (dataset.activation_hat.values for dataset in found)
    assert np.ptp(named) > 0.1
    np.testing.assert_allclose(own, named, rtol=0, atol=2e-5)
    np.testing.assert_allclose(found[1].velocity_hat, found[0].velocity_hat, rtol=0, atol=1e-5)


def test_a_bad_table_ends_with_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "own.csv").write_text(csv_of(with_points("force_velocity", at(40, y=-1.0))))
    arguments = ["estimate", DATA / "gains_dgf_random_noisy.csv", "--muscles", muscle_file(tmp_path, "own.csv")]
    ran = CliRunner().invoke(commands, [*map(str, arguments), "--out", str(tmp_path / "out")])
    assert ran.exit_code == 2
    assert "own.csv: force_velocity: y must rise from point to point, and point 41" in ran.output
    assert "Traceback" not in ran.output
