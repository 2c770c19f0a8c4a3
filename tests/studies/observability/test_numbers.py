"""Numbers of muscles as coordinates: what of them the outputs determine, beside the states."""

import json

import pytest

from hillobs.model.block import Block, BlockError, Parameter, Symbols, symbols
from hillobs.observers.observability import Verdict, judge, observability_matrix, with_constants
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.observability.point import observability

# a fibre longer than its best length, far from all limits
LONG = {"x1": 3.2, "x2": 0.05, "x3": 2.03, "a1": 0.8}


def growth(names: str, at: list[float]) -> Verdict:
    """ẋ = (product of the numbers) x, y = x, at x and the numbers."""
    x, p = symbols("x"), symbols(names)
    product = x.x
    for number in p.values():
        product = product * number
    parameters = {name: Parameter(1.0, "rate", "chosen") for name in p}
    plain = Block("growth", x=x, p=p, parameters=parameters, dx=Symbols(x=product), y=Symbols(y=x.x))
    block = with_constants(plain, list(p))
    matrix = observability_matrix(block, ["y"], len(block.x))(at, [], [])
    return judge(matrix.full(), list(block.x), dict.fromkeys(block.x, 1.0), 1)


def test_a_rate_is_told_while_something_grows() -> None:
    assert growth("r", [1.0, 2.0]).full
    assert growth("r", [0.0, 2.0]).unobservable == ("r",)


def test_of_two_factors_the_product_is_told() -> None:
    """r + δ, s − δ s/r leave it as it is."""
    found = growth("r s", [1.0, 2.0, 4.0])
    assert found.rank == 2
    assert found.null_directions == (pytest.approx({"r": -0.5, "s": 1.0}),)


def test_what_stays_is_no_input_and_no_parameter() -> None:
    x, p = symbols("x"), symbols("r")
    block = Block("one", x=x, p=p, parameters={"r": Parameter(1.0, "rate", "chosen")}, dx=Symbols(x=p.r))
    known = with_constants(block, ["r"])
    assert (list(known.x), list(known.p), known.parameters) == (["x", "r"], [], {})
    with pytest.raises(BlockError, match="one: no number k; there are r"):
        with_constants(block, ["k"])


def test_a_long_fibre_tells_its_passive_stiffness_and_a_short_one_does_not() -> None:
    """Φ_P = k_P max(L_C − 1, 0)³, so nothing of k_P acts below 1, and no higher derivative brings it back."""
    asked = {"parameters": ["muscle1.k_P"]}
    assert observability(place=LONG, **asked).verdict.full
    assert observability(place={**LONG, "x1": 2.7}, **asked).verdict.unobservable == ("muscle1.k_P",)


def test_a_slack_tendon_tells_nothing_of_itself() -> None:
    lost = observability(place={**LONG, "x3": 1.95}, parameters=["muscle1.L_slack", "muscle1.k"]).verdict.unobservable
    assert {"muscle1.L_slack", "muscle1.k", "x3"} <= set(lost)


def test_an_unknown_activation_hides_what_a_known_one_tells() -> None:
    """Where it changes as it likes it makes any force, whatever the largest one is."""
    asked = {"place": LONG, "parameters": ["muscle1.k_P"]}
    known, unknown = (observability(unknown=unknown, **asked) for unknown in ("none", "a"))
    assert known.verdict.full
    assert known.lost_as_functions is None
    assert "muscle1.k_P" in (unknown.lost_as_functions or ())
    assert known.deviations["muscle1.k_P"] < unknown.deviations["muscle1.k_P"]


def test_a_muscle_stands_for_all_its_numbers() -> None:
    asked = observability(place=LONG, parameters=["muscle1"], order=1).verdict.coordinates
    assert {"muscle1.L_slack", "muscle1.k", "muscle1.W", "muscle1.k_P"} < set(asked)
    assert not [name for name in asked if name.startswith("muscle2.")]


def test_a_wrong_number_is_named() -> None:
    with pytest.raises(
        ScenarioError, match=r"unknown number 'muscle1.F_max' of a muscle; the nearest are muscle1.g_max"
    ):
        observability(parameters=["muscle1.F_max"])


def test_the_command_says_what_is_asked(command) -> None:
    at = ",".join(f"{name}={value}" for name, value in LONG.items())
    code, out, _ = command("observability", "--at", at, "--parameters", "muscle1.k_P,muscle1.L_slack")
    assert "activations and uncertainty known; numbers muscle1.L_slack, muscle1.k_P unknown: rank" in out
    code, out, _ = command("observability", "--at", at, "--parameters", "muscle1.k_P", "--json")
    answer = json.loads(out)
    assert (code, answer["parameters"]) == (0, ["muscle1.k_P"])
    assert answer["weakest"]
    code, _, err = command("observability", "--parameters", "muscle1", "--along")
    assert code == 2
    assert "--parameters asks at one point, and goes without --along and --map" in err
