"""The muscle file: what it must hold, what it means without dimensions, and the way back."""

import copy
import json
import math
import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.model.block import Parameter
from hillobs.model.curves import CURVES, NGUYEN2019
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.muscles import SCALED, SIZES, MusclePair, muscle_file, muscle_pair, read_muscles
from hillobs.studies.laboratory.scales import scales
from hillobs.studies.laboratory.subject import pair_subject
from hillobs.studies.scenarios.loops import all_paths
from places import DOCS, RECORDINGS

SETS = {"dgf_smooth": "degroote_fregly2016", "dgf_random": "degroote_fregly2016", "millard_steps": "millard2012"}


@pytest.fixture(autouse=True)
def _sets_with_sizes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A set with sizes, strains and damping, whatever else there is."""
    further = {"tendon_strain": Parameter(0.049, "", "", above=0), "F_max": Parameter(1.0, "", "", above=0)}
    sizes = {"l_opt": Parameter(1.0, "", "", above=0), "v_max": Parameter(1.0, "", "", above=0)}
    own = {"passive_strain": Parameter(0.6, "", "", above=0), "damping": Parameter(0.0, "", "", least=0)}
    sized = replace(NGUYEN2019, name="sized", tendon={**NGUYEN2019.tendon, **further}, fibre={**sizes, **own})
    for name in ("sized", *SETS.values()):
        if name not in CURVES:
            monkeypatch.setitem(CURVES, name, sized)


TEXT = """
description = "a test"
mass = 20
C = 0.62
[muscle]
curves = "sized"
F_max = 1000.0
optimal_fibre_length = 0.1
tendon_slack_length = 0.2
v_max = 10.0
[muscle2]
F_max = 500.0
optimal_fibre_length = 0.05
damping = 0.1
"""


def document() -> dict[str, Any]:
    return tomllib.loads(TEXT)


@pytest.mark.parametrize("name", [*SETS, "inline"])
def test_a_pair_as_a_muscle_file_is_the_same_pair(name: str) -> None:
    content = tomllib.loads((RECORDINGS / f"{name}.toml").read_text()) if name in SETS else document()
    if name == "inline":
        content["muscle1"] = {"curves": tables()}
        content["muscle"]["curves"] = "degroote_fregly2016"
    pair = muscle_pair(content)
    text = json.dumps(muscle_file(pair))
    # as text and back no number loses a bit
    assert muscle_pair(json.loads(text)) == pair
    assert json.dumps(muscle_file(muscle_pair(json.loads(text)))) == text


def tables() -> dict[str, Any]:
    """A tendon, a passive fibre, a hill and a force factor, in own units."""
    x = [i / 10 for i in range(21)]
    return {
        "tendon_force_length": [[1 + v / 20, v] for v in x],
        "passive_force_length": [[v, max(0.0, v - 1)] for v in x],
        "active_force_length": [[v, max(0.0, 1 - 4 * (v - 1) ** 2)] for v in x],
        "force_velocity": [[v - 1, v] for v in x],
    }


def test_tables_in_a_muscle_file_are_those_of_a_file_of_curves(tmp_path: Path) -> None:
    rows = [f"{curve},{x!r},{y!r}" for curve, points in tables().items() for x, y in points]
    (tmp_path / "curves.csv").write_text("curve,x,y\n" + "\n".join(rows) + "\n")
    inline, beside = document(), document()
    inline["muscle"]["curves"], beside["muscle"]["curves"] = tables(), "curves.csv"
    for content in (inline, beside):
        del content["muscle2"]["damping"]
    assert muscle_pair(inline) == muscle_pair(beside, tmp_path)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"force_velocity": None}, "must have the tables tendon_force_length, passive_force_length, active_force_"),
        ({"force": [[0, 1]]}, "must have the tables tendon_force_length"),
        ({"force_velocity": 3}, "tables must be lists of points [x, y]"),
        ({"force_velocity": [[0, 1, 2]]}, "tables must be lists of points [x, y]"),
        ({"force_velocity": [[0, "1"]]}, "tables must be lists of points [x, y]"),
        ({"force_velocity": [[0, True]]}, "tables must be lists of points [x, y]"),
        ({"force_velocity": [[0, 1]]}, "force_velocity: has 1 points; a curve needs 4 to 5,000"),
        ({"force_velocity": [[math.nan, 1]] * 4}, "force_velocity: point 1, (nan, 1), must be two numbers within"),
    ],
)
def test_wrong_tables_in_a_muscle_file_are_sentences(change: dict[str, Any], sentence: str) -> None:
    content = document()
    content["muscle"]["curves"] = {name: points for name, points in (tables() | change).items() if points is not None}
    with pytest.raises(ScenarioError) as caught:
        muscle_pair(content)
    assert str(caught.value).startswith(f"muscle.curves: {sentence}")


def pair_of(text: str = TEXT) -> MusclePair:
    return muscle_pair(tomllib.loads(text))


@pytest.mark.parametrize(
    ("name", "strains"), [("dgf_smooth", (0.049, 0.6)), ("dgf_random", (0.04, 0.6)), ("millard_steps", (0.04, 0.7))]
)
def test_the_files_of_the_public_recordings(name: str, strains: tuple[float, float]) -> None:
    pair = read_muscles(RECORDINGS / f"{name}.toml")
    assert (pair.mass, pair.C, pair.muscle1) == (20.0, 0.62, pair.muscle2)
    one = pair.muscle1
    assert (one.curves.name, one.F_max, one.optimal_fibre_length) == (SETS[name], 1000.0, 0.1)
    assert (one.tendon_slack_length, one.v_max) == (0.2, 10.0)
    assert (one.numbers["tendon_strain"], one.numbers["passive_strain"], one.numbers["damping"]) == (*strains, 0.0)
    assert len(pair.description) > 20
    numbers = scales(pair).numbers
    assert numbers["plant.m"] == pytest.approx(0.2, rel=1e-15)
    assert numbers["plant.C"] == pytest.approx(6.2, rel=1e-15)
    assert (numbers["muscle1.L_slack"], numbers["muscle2.L_slack"]) == (2.0, 2.0)


def test_the_file_in_the_docs_is_one() -> None:
    page = (DOCS / "recordings.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    assert scales(pair_of(text)).numbers["plant.m"] == pytest.approx(0.2)


def test_a_muscle_has_its_own_numbers_before_those_of_both() -> None:
    pair = pair_of()
    assert (pair.muscle1.F_max, pair.muscle2.F_max, pair.muscle2.v_max) == (1000.0, 500.0, 10.0)
    assert (pair.muscle1.numbers["damping"], pair.muscle2.numbers["damping"]) == (0.0, 0.1)
    # what a set has beside the sizes may be left out
    assert pair.muscle1.numbers["tendon_strain"] == 0.049


def test_a_second_muscle_is_measured_by_the_first() -> None:
    numbers = scales(pair_of()).numbers
    assert numbers["muscle1.F_max"] == numbers["muscle1.l_opt"] == numbers["muscle1.v_max"] == 1
    assert (numbers["muscle2.F_max"], numbers["muscle2.l_opt"], numbers["muscle2.v_max"]) == (0.5, 0.5, 1.0)
    assert numbers["muscle2.L_slack"] == 2.0
    assert numbers["muscle2.damping"] == 0.1
    assert numbers["plant.m"] == pytest.approx(20 * 0.1 * 10**2 / 1000)


def test_the_paper_s_pair_is_its_own_scale() -> None:
    """In metres, newtons and seconds that are the reference values, nothing changes."""
    pair = pair_of(
        "mass = 1\nC = 5.54\n[muscle]\ncurves = 'nguyen2019'\nF_max = 1\noptimal_fibre_length = 1\n"
        "tendon_slack_length = 2\nv_max = 1\n"
    )
    table = all_paths()
    for path, value in scales(pair).numbers.items():
        assert value == table.parameters[path].default, path


@given(st.floats(1e-3, 1e3), st.floats(0.01, 1), st.floats(1, 1e5), st.floats(1, 30), st.floats(-1e3, 1e3))
def test_the_way_back_inverts_and_keeps_newton(mass: float, length: float, force: float, rate: float, x: float) -> None:
    content = document()
    content |= {"mass": mass, "C": 15 * length}
    content["muscle"] |= {
        "F_max": force,
        "optimal_fibre_length": length,
        "v_max": rate,
        "tendon_slack_length": 2 * length,
    }
    content["muscle2"] = {}
    subject = pair_subject(muscle_pair(content))
    s = subject.scales
    value = np.array([x])
    np.testing.assert_allclose(s.metres(s.lengths(value)), value, rtol=1e-14)
    # a fibre that lengthens has u < 0, and d(L_C)/dτ = −u
    np.testing.assert_allclose(s.fibre_velocity(-s.lengths(value)), value * rate, rtol=1e-14)
    # dx₂/dτ = (Φ_S2 − Φ_S1)/m + Δ_Φ is mass·acceleration = force_2 − force_1 + disturbance
    m, Delta = s.numbers["plant.m"], np.array([0.3])
    rise = s.forces(value) / m + Delta
    acceleration = s.velocity(rise) * rate
    total = value + subject.disturbance(value, Delta)
    np.testing.assert_allclose(mass * acceleration, total, rtol=1e-12, atol=1e-12 * force)
    np.testing.assert_allclose(s.tau(value), x * rate)


def _without(*path: str) -> Callable[[dict[str, Any]], None]:
    def change(content: dict[str, Any]) -> None:
        for key in path[:-1]:
            content = content[key]
        del content[path[-1]]

    return change


def _with(value: object, *path: str) -> Callable[[dict[str, Any]], None]:
    def change(content: dict[str, Any]) -> None:
        for key in path[:-1]:
            content = content[key]
        content[path[-1]] = value

    return change


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (_without("mass"), "mass is missing"),
        (_without("muscle", "v_max"), "muscle1.v_max, muscle2.v_max are missing"),
        (_without("muscle", "F_max"), "muscle1.F_max is missing"),
        (_without("muscle", "curves"), f"muscle1.curves is missing; there are {NGUYEN2019.name}"),
        (_with("hill", "muscle", "curves"), "muscle.curves must be one of nguyen2019"),
        (_with("hill", "muscle2", "curves"), "muscle2.curves must be one of nguyen2019"),
        (_with(1, "muscle2", "curves"), "muscle2.curves must be one of nguyen2019"),
        (_with(0.0, "mass"), "mass must be at least 1e-09, not 0"),
        (_with(math.nan, "C"), "C must be a finite number, not nan"),
        (_with(True, "C"), "C must be a number, not true"),
        (_with("0.62", "C"), "C must be a number, not '0.62'"),
        (_with(0.4, "C"), "C = 0.4 must be above both tendon slack lengths together, 0.4"),
        (_with(-1.0, "muscle2", "F_max"), "muscle2.F_max must be at least 1e-06, not -1"),
        (_with(100.0, "muscle", "optimal_fibre_length"), "muscle.optimal_fibre_length must be below 10, not 100"),
        (_with(50.0, "muscle2", "optimal_fibre_length"), "muscle2.optimal_fibre_length must be below 10, not 50"),
        (_with(10**400, "muscle", "v_max"), "muscle.v_max must be a finite number, not inf"),
        (_with(0, "muscle", "tendon_strain"), "muscle.tendon_strain must be above 0, not 0"),
        (_with(1.0, "muscle2", "Fmax"), "unknown key 'muscle2.Fmax'; the nearest are muscle2.F_max"),
        (_with(1.0, "muscle", "k_toe"), "unknown key 'muscle.k_toe'; the nearest are "),
        (_with(1.0, "masss"), "unknown key 'masss'; the nearest are mass"),
        (_with({}, "muscle3"), "unknown key 'muscle3'; the nearest are muscle"),
        (_with(3, "muscle1"), "muscle1 must be a table, [muscle1], not 3"),
        (_with([1], "muscle"), "muscle must be a table, [muscle], not [1]"),
        (_with(3, "description"), "description must be a text, not 3"),
        (_with({"a": 1}, "muscle2", "F_max"), "muscle2.F_max must be a number, or { value = …, sd = … }, not a table"),
    ],
)
def test_a_wrong_key_is_named(change: Callable[[dict[str, Any]], None], sentence: str) -> None:
    content = copy.deepcopy(document())
    change(content)
    with pytest.raises(ScenarioError) as caught:
        muscle_pair(content)
    assert str(caught.value).startswith(sentence)


def test_curves_without_size_must_be_those_of_the_reference() -> None:
    mixed = TEXT.replace("[muscle2]", "[muscle1]\ncurves = 'nguyen2019'\n[muscle2]")
    numbers = scales(pair_of(mixed)).numbers
    assert numbers["muscle1.k"] == NGUYEN2019.parameters["k"].default
    assert "muscle1.F_max" not in numbers
    other = TEXT.replace("damping = 0.1", "curves = 'nguyen2019'")
    with pytest.raises(
        ScenarioError, match=r"muscle2: curves nguyen2019 have no size of their own: F_max, l_opt must be"
    ):
        scales(pair_of(other))


def test_a_tendon_that_does_not_rise_is_refused() -> None:
    text = TEXT.partition("[muscle2]")[0].replace("sized", "nguyen2019")
    with pytest.raises(ScenarioError, match="muscle1: k·toe = 4 must be below"):
        scales(pair_of(text + "k = 100.0\n"))


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"mass = \n", "not valid TOML"),
        (b"\xef\xbb\xbfmass = 1\n", "byte-order mark"),
        (b"# \xff\n", "line 1 is not valid UTF-8"),
        (b"mass = 1\n[muscle]\ncurves = 'sized'\n", "C, muscle1.F_max, muscle1.optimal_fibre_length"),
        (b"#" * 300_000, "larger than"),
    ],
)
def test_a_wrong_file_is_one_sentence_that_names_it(content: bytes, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "muscles.toml"
    path.write_bytes(content)
    with pytest.raises(ScenarioError) as caught:
        read_muscles(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert sentence in str(caught.value)
    with pytest.raises(ScenarioError, match=r"nowhere\.toml: cannot be read: No such file"):
        read_muscles(tmp_path / "nowhere.toml")


def test_the_sizes_are_those_of_the_curve_sets() -> None:
    """Whatever set there is, its sizes have these names; everything else is a number of the file."""
    for curves in CURVES.values():
        assert curves.parameters.keys() & set(SCALED.values()) in ({"L_slack"}, set(SCALED.values())), curves.name


@pytest.mark.parametrize("exponent", [-300, -70, 70, 300])
@pytest.mark.parametrize("key", ["mass", "C", *SIZES, "tendon_strain", "passive_strain", "damping"])
def test_a_number_beyond_any_muscle_is_refused_by_name(key: str, exponent: int) -> None:
    pair = read_muscles(RECORDINGS / "dgf_smooth.toml")
    content = muscle_file(pair)
    section = content if key in content else content["muscle1"]
    if key == "damping" and exponent < 0:
        return  # as good as none
    section[key] = 10.0**exponent
    with pytest.raises(ScenarioError, match=rf"{key} must be (at least|at most|below) "):
        muscle_pair(content)
