"""Every observer of the registry, and any of a user's own, passes the same checks; a wrong one does not."""

import dataclasses

import pytest

from few_observers import few_observers
from hillobs.model.block import Block, Parameter, Symbols, symbols
from hillobs.model.system import PAIR
from hillobs.observers import OBSERVERS, baseline_estimator
from hillobs.observers.conditions import FACTS, check
from hillobs.studies.conformance import conformance
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.scenarios.prepare import prepare


@pytest.mark.parametrize("name", OBSERVERS)
def test_ours_conform(name: str) -> None:
    assert conformance(OBSERVERS[name].block()) == []


@pytest.mark.parametrize("beside", [("high_gain",), pytest.param(tuple(OBSERVERS), marks=pytest.mark.chaos)], ids=len)
def test_a_users_own_conforms_beside_ours(beside: tuple[str, ...], proportional: Block) -> None:
    with few_observers(*beside):
        assert conformance(proportional) == []


def test_a_missing_port_is_named(proportional: Block) -> None:
    y = Symbols({name: value for name, value in proportional.y.items() if name != "Delta_hat"})
    assert conformance(dataclasses.replace(proportional, y=y)) == [
        "proportional: an observer must estimate Delta_hat as well"
    ]


def test_an_observer_sees_the_sensors_only(proportional: Block) -> None:
    cheat = dataclasses.replace(proportional, u=Symbols({**proportional.u, **symbols("x2")}))
    assert conformance(cheat) == [
        "proportional: an observer sees t, y1, y2, y3, L_S1, L_S2, slope1, slope2 only, not x2"
    ]


def test_what_is_not_finite_for_a_slack_tendon_is_found(proportional: Block) -> None:
    u = proportional.u
    broken = dataclasses.replace(proportional, dx=Symbols({**proportional.dx, "x3_hat": u.y1 / u.y2}))
    assert conformance(broken)[0] == "proportional: step not finite at the measured forces 0"


def test_what_is_not_finite_at_a_sample_is_found(proportional: Block) -> None:
    u, dx = proportional.u, Symbols({name: rate for name, rate in proportional.dx.items() if name != "x3_hat"})
    broken = dataclasses.replace(proportional, dx=dx, next=Symbols(x3_hat=u.y1 / u.y2))
    assert conformance(broken)[0] == "proportional: sample not finite at the measured forces 0"


def test_an_undescribed_parameter_is_found(proportional: Block) -> None:
    bare = dataclasses.replace(proportional, parameters={"gain": Parameter(1.0, "", "", above=0)})
    assert conformance(bare) == ["proportional: parameter gain needs a sentence, a source and a unit"]


def facts(**changes: float) -> dict[str, float]:
    known = {"h": 5e-4, "U_m": 0.9, "f_plus": 1.0, "p": 0.5, "sup_dDelta": 0.004, "sup_du1": 0.02, "sup_du2": 0.02}
    return {**known, **changes}


def violated(name: str, **changes: float) -> list[str]:
    observer = OBSERVERS[name]
    block, about = observer.block(), symbols(FACTS)
    values = {key: changes.get(key, parameter.default) for key, parameter in block.parameters.items()}
    known = facts(**{key: value for key, value in changes.items() if key in FACTS})
    results = check(observer.conditions(PAIR, block.p, about), Symbols({**block.p, **about}), {**values, **known})
    return [str(result) for result in results if not result.holds]


def test_the_papers_gains_meet_their_conditions_but_for_the_rounded_one() -> None:
    assert violated("high_gain") == violated("high_gain_3") == []
    assert violated("adaptive_sliding_mode") == violated("levant") == []
    (only,) = violated("sliding_mode")
    assert "[lambda11]: 28.17 > 28.17446 does not hold" in only


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("high_gain", {"h13": 9.5}, "h₁₁h₁₂ > h₁₃: 9 > 9.5"),
        ("high_gain", {"eps_h": 1.5}, "0 < ε_h < 1: 1.5 < 1"),
        ("high_gain", {"h22": -1.0}, "h22 > 0: -1 > 0"),
        ("sliding_mode", {"alpha3": 0.9}, "α₃ > U₂ₘ [alpha3]: 0.9 > 0.9"),
        ("sliding_mode", {"h": 0.03}, "h α/δ_L < 2.5 (integration): 3.3 < 2.5"),
        ("sliding_mode", {"delta_L": 2e-4}, "h α/δ_L < 2.5 (integration): 2.75 < 2.5"),
        ("sliding_mode", {"delta_s": 1e-6}, "h 0.55 λ₁₁/√δ_s < 2.5 (integration): 7.74675 < 2.5"),
        ("sliding_mode", {"tau_s": 1e-4}, "h 1/τ_s < 2.5 (integration): 5 < 2.5"),
        ("high_gain", {"eps_L": 5e-4}, "h ρ/ε_L < 0.75 (integration): 1 < 0.75"),
        ("high_gain_3", {"h13": 64.0, "eps_h": 2e-3}, "h ρ/ε_h < 0.75 (integration): 1 < 0.75"),
        ("high_gain_3", {"h23": 9.5}, "chain of e₃ Hurwitz: h21 h22 > h23: 9 > 9.5"),
        ("adaptive_sliding_mode", {"a_dual": 0.95}, "0 < a < 1/β₀: 0.95 < 0.9090909"),
        ("adaptive_sliding_mode", {"alpha0": 2.97}, "α₀ = 2√(2β₀): 2.97 = 2.966479"),
        ("adaptive_sliding_mode", {"h": 5e-3}, "h (r₀ + r_max)/δ_a < 2.5 (integration): 10.25 < 2.5"),
        ("adaptive_sliding_mode", {"sup_du1": 2.0}, "(dual layer): 0.01 >"),
        ("levant", {"sup_dDelta": 0.06}, "L_D > sup|Δ̇|: 0.056 > 0.06"),
        ("levant", {"sup_du2": 0.2}, "L_u2 > sup|u̇₂|: 0.12 > 0.2"),
        ("levant", {"eps_L": 5e-4}, "h ρ/ε_L < 0.75 (integration): 1.048809 < 0.75"),
    ],
)
def test_a_violated_condition_is_reported_with_both_numbers(name: str, change: dict[str, float], words: str) -> None:
    assert any(words in sentence for sentence in violated(name, **change))


def test_the_baseline_has_no_state() -> None:
    assert list(baseline_estimator().x) == []


@pytest.mark.parametrize("name", ["C", "u_high", "muscle1.W"])
def test_a_parameter_of_the_activation_is_not_taken_over_by_accident(proportional: Block, name: str) -> None:
    p = Symbols({name: proportional.p.gain})
    own = dataclasses.replace(proportional, p=p, parameters={name: proportional.parameters["gain"]})
    (complaint,) = conformance(own)
    assert complaint.startswith(f"proportional: the activation wired to it has a parameter {name} too")


@pytest.mark.parametrize("name", ["high_gain", "baseline", "truth", "noise", "plant", "muscle1", "pulse", "score"])
def test_a_name_that_a_scenario_uses_is_refused(proportional: Block, name: str) -> None:
    with pytest.raises(ScenarioError, match=f"the name '{name}' is taken"):
        prepare("paper-clean", [dataclasses.replace(proportional, name=name)], {})
