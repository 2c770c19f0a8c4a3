"""Which numbers are in doubt and by how much: from the command, from the muscle file, as usual; and what cannot be."""

import dataclasses
import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hillobs.model.curves import CURVES
from hillobs.studies.estimate.bands.doubt import USUAL, doubts, parse_doubt
from hillobs.studies.estimate.bands.taut import taut
from hillobs.studies.estimate.run import estimate
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.muscles import SIZES, muscle_file, muscle_pair, numbers_of, read_muscles
from hillobs.studies.laboratory.recording import Recording
from hillobs.studies.laboratory.subject import subject_of
from shipped_recording import MUSCLES, write_measured

pytestmark = pytest.mark.numerics

PAIR = read_muscles(MUSCLES)
TEXT = MUSCLES.read_text()
WITH_SDS = TEXT.replace("= 0.1  # m", "= { value = 0.1, sd = 0.004 }").replace(
    "mass = 20.0", 'mass = { value = 20.0, sd = "2%" }'
)
ONE = WITH_SDS + "[muscle2]\noptimal_fibre_length = 0.1\nF_max = { value = 1000.0, sd = '0.1kN' }\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "muscles.toml"
    path.write_text(text)
    return path


def test_what_is_given_comes_before_the_file_and_the_file_before_what_is_usual(tmp_path: Path) -> None:
    pair = read_muscles(written(tmp_path, ONE))
    found = doubts(
        subject_of(pair), {"v_max": "20%", "muscle1.v_max": 0.5, "force_bias": "5 N", "position_bias": "0.1mm"}, True
    )
    expected = {
        "optimal_fibre_length": (0.004, 0.003),  # [muscle2] has a number of its own, without a deviation
        "F_max": (50.0, 100.0),
        "v_max": (0.5, 2.0),
        "tendon_slack_length": (0.002, 0.002),
        "force_bias": (5.0, 5.0),
    }
    for number, both in expected.items():
        assert [found[f"muscle{j}.{number}"] for j in (1, 2)] == pytest.approx(both), number
    assert (found["mass"], found["position_bias"]) == pytest.approx((0.4, 1e-4))
    assert not {"C", "muscle1.damping"} & found.keys()
    alone = doubts(subject_of(pair), {"muscle2.damping": 0.1}, usual=False)
    assert alone == {"muscle2.damping": 0.1}


def test_deviations_of_a_muscle_file_stay_with_it(tmp_path: Path) -> None:
    pair = read_muscles(written(tmp_path, ONE))
    content = json.loads(json.dumps(muscle_file(pair)))
    assert content["muscle1"]["optimal_fibre_length"] == {"value": 0.1, "sd": 0.004}
    assert muscle_pair(content) == pair
    # a number may be changed in Python, and its deviation stays in its unit
    assert dataclasses.replace(pair.muscle1, optimal_fibre_length=0.11).sds == {"optimal_fibre_length": 0.004}
    plain = dataclasses.replace(pair.muscle1, sds={})
    assert plain == PAIR.muscle1


def test_every_usual_doubt_is_of_a_number_that_some_curves_have() -> None:
    known = {*SIZES, *(name for curves in CURVES.values() for name in numbers_of(curves))}
    assert USUAL.keys() <= known


BAD = [
    ("optimal_fiber_length=3%", "unknown number 'optimal_fiber_length' in doubt; the nearest are optimal_fibre_length"),
    ("muscle3.F_max=3%", "unknown number 'muscle3.F_max' in doubt; the nearest are muscle2.F_max, muscle1.F_max"),
    ("x=1", "unknown number 'x' in doubt; the nearest are F_max, optimal_fibre_length"),
    ("optimal_fibre_length", "'optimal_fibre_length' is not NAME=SD, such as optimal_fibre_length=3% or force_bias=5N"),
    ("F_max=0", "the sd of muscle1.F_max must be above 0, not 0.0"),
    ("F_max=-3%", "the sd of muscle1.F_max must be above 0, not '-3%'"),
    ("F_max=three%", "the sd of muscle1.F_max must be a number, or a text such as 3%, not 'three%'"),
    ("F_max=%", "the sd of muscle1.F_max must be a number, or a text such as 3%, not '%'"),
    ("F_max=1e999%", "the sd of muscle1.F_max must be a finite number, not inf"),
    ("F_max=3mm", "the sd of muscle1.F_max must be in N or in %, not '3mm'"),
    ("damping=3mm", "the sd of muscle1.damping must be in %, or a number without a unit, not '3mm'"),
    ("v_max=3rad", "the sd of muscle1.v_max must be in 1/s or in %, not '3rad'"),
    (
        "optimal_fibre_length=3",
        "the sd of muscle1.optimal_fibre_length, 3 m, is more than the number itself, 0.1; a part",
    ),
    ("force_bias=3%", "the sd of muscle1.force_bias must be a number, not a part of it, '3%': it is 0"),
    ("damping=3%", "the sd of muscle1.damping must be a number, not a part of it, '3%': it is 0"),
]


@pytest.mark.parametrize(("typed", "sentence"), BAD, ids=[typed for typed, _ in BAD])
def test_what_is_no_doubt_is_one_sentence(
    typed: str, sentence: str, short: Recording, command: Callable[..., tuple[int, str, str]]
) -> None:
    write_measured(short, Path("short.csv"))
    code, _, err = command("estimate", "short.csv", "--muscles", str(MUSCLES), "--no-figures", "--doubt", typed)
    assert code == 2
    assert err.startswith(f"hillobs: {sentence}")
    assert err.count("\n") == 1
    assert not Path("estimates", "estimates.nc").exists()


@pytest.mark.parametrize(
    ("sd", "sentence"),
    [
        ("{ value = 0.1, sd = 0 }", "muscle.optimal_fibre_length must be above 0, not 0"),
        ("{ value = 0.1, sd = '0 %' }", "muscle.optimal_fibre_length must be above 0, not '0 %'"),
        ("{ value = 0.1, sd = 3.0 }", "muscle.optimal_fibre_length, 3 m, is more than the number itself"),
        ("{ value = 0.1, sd = '1e-3' }", "must be a number, or a text such as 3%, not '1e-3'"),
        ("{ value = 0.1, sd = true }", "muscle.optimal_fibre_length must be a number, not true"),
        ("{ value = 0.1, sd = [1] }", "muscle.optimal_fibre_length must be a number, not [1]"),
        ("{ value = 'a', sd = 1 }", "muscle.optimal_fibre_length must be a number, not 'a'"),
        ("{ value = 0.1 }", "muscle.optimal_fibre_length has a value without an sd; a number without one stands alone"),
        ("{ sd = 0.1 }", "muscle.optimal_fibre_length must be a number, or { value = …, sd = … }, not a table"),
        ("{ value = 0.1, sd = 0.1, s = 1 }", "muscle.optimal_fibre_length must be a number, or { value = …, sd = … }"),
    ],
)
def test_what_is_no_deviation_in_a_muscle_file_is_one_sentence(sd: str, sentence: str, tmp_path: Path) -> None:
    path = written(tmp_path, TEXT.replace("= 0.1  # m", f"= {sd}"))
    with pytest.raises(ScenarioError) as caught:
        read_muscles(path)
    assert sentence in str(caught.value)
    assert str(caught.value).startswith(f"{path}: ")


@pytest.mark.parametrize("sds", [{"F_max": 0.0}, {"F_max": math.nan}, {"F_max": "x"}, {"width": 1.0}, 3, {3: 1.0}])
def test_what_is_no_deviation_in_python_is_one_sentence(sds: object) -> None:
    with pytest.raises(ScenarioError):
        dataclasses.replace(PAIR.muscle1, sds=sds)


@pytest.mark.parametrize(
    "doubt", [{"F_max": None}, {"F_max": math.inf}, {"F_max": "50"}, {1: 0.1}, ["F_max"], {"F_max": [1]}]
)
def test_what_is_no_doubt_in_python_is_one_sentence(doubt: object, short: Recording) -> None:
    with pytest.raises(ScenarioError):
        estimate(short, MUSCLES, doubt=doubt)


def test_a_doubt_is_typed_with_or_without_its_unit() -> None:
    assert parse_doubt("F_max=50") == ("F_max", 50.0)
    assert parse_doubt(" F_max = 5 % ") == ("F_max", "5 %")
    assert doubts(subject_of(PAIR), {"C": "1e1 mm"}, usual=False) == pytest.approx({"C": 0.01})


def test_a_number_is_not_doubted_twice(command: Callable[..., tuple[int, str, str]]) -> None:
    given = ("estimate", "short.csv", "--muscles", str(MUSCLES), "--doubt", "F_max=3%", "--doubt", "F_max=4%")
    code, _, err = command(*given)
    assert (code, err) == (2, "hillobs: a number is given to --doubt twice\n")


def test_a_length_is_known_from_five_sigma_on_until_the_force_is_gone() -> None:
    force = np.array([3.0, 6.0, 4.0, 1.0, 0.0, 4.0, 5.0, 5.1, 2.0, -1.0, 6.0])
    known = [False, True, True, True, False, False, False, True, True, False, True]
    assert taut(force, 1.0).tolist() == known
    # without noise all that is taut
    assert taut(force, 0.0).tolist() == (force > 0).tolist()
