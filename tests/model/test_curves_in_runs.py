"""Curve sets at work: compiled, in the pair, in scenarios, drawn and listed."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from click.testing import CliRunner

from curve_values import OTHER, RANGES, SETS, at, numbers
from few_observers import few_observers
from hillobs.codegen.shared_library import compile_functions
from hillobs.model.block import symbols
from hillobs.model.curves import CURVES, NGUYEN2019_PRINTED, SIMULATED
from hillobs.studies.cli.main import commands
from hillobs.studies.figures.muscle_curves import curve_figure
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.scenarios.layers import Layer, layer
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.scenarios.scenario import choices
from hillobs.studies.scenarios.world import curves_of
from hillobs.studies.simulate.run import simulate
from places import contents


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
    curves = {"muscle1.curves": "degroote_fregly2016", "muscle2.curves": "thelen2003"}
    changes = {"plant.drive": "given", **curves, **own}
    start = {"initial.x1": 2.8, "initial.x3": 2.03, "initial.x4": 2.13, "plant.C": 5.8}
    with few_observers("high_gain"):
        run = simulate("paper-clean", ["high_gain"], {**changes, **start, "duration": 0.5, "step": 1e-3})
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


def test_every_set_is_drawn_and_listed(tmp_path: Path) -> None:
    ran = CliRunner().invoke(commands, ["curves", "--pdf", "--out", str(tmp_path)])
    assert ran.exit_code == 0, ran.output
    assert sorted(contents(tmp_path)) == ["curves-sets.pdf", "curves-sets.png"]
    figure = curve_figure()
    for axes in figure.axes:
        assert len(axes.lines) == len(SIMULATED)
        assert all(np.isfinite(np.asarray(line.get_ydata(), dtype=float)).all() for line in axes.lines)
    listed = CliRunner().invoke(commands, ["list", "curves"]).output
    assert all(f"{name} " in listed for name in CURVES)
    assert "tendon_strain 0.049" in listed
