"""The controller on an observer's estimates: the same observer inside the loop as beside it, and what it costs."""

import dataclasses
import json
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
import xarray as xr

import hillobs
from hillobs.codegen.batch import compile_loop
from hillobs.model.block import Block, BlockError, Symbols, symbols
from hillobs.model.wiring import wire
from hillobs.observers import OBSERVERS
from hillobs.observers.feedback import saturation
from hillobs.studies.cli.reports.simulate import notes
from hillobs.studies.export.pages import export_page
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.simulate.run import recorded
from hillobs.studies.sweep import plan as planning
from hillobs.studies.sweep.plan import plan

FEEDBACK, DELTA = "controller.feedback", "controller.Delta"
CLOSED = {FEEDBACK: "high_gain", DELTA: "estimated"}
SHORT = {"duration": 1.0, "score.start": 0.2}
# root mean square of x₁ − r from 8 on, by another program: true states, then each observer without noise and Δ known,
# and with noise and Δ̂ (median of seeds)
BY_ANOTHER = {
    "high_gain": (1.2e-4, 1.5e-4),
    "sliding_mode": (8.2e-4, 2.8e-3),
    "adaptive_sliding_mode": (6.4e-4, 1.8e-3),
    "kalman_constant": (2.1e-4, 2.7e-4),
}


def tracking(run: xr.Dataset) -> float:
    late = run.sel(time=slice(8, None))
    return float(np.sqrt(((late.x.sel(state="x1") - late.r) ** 2).mean()))


def test_what_the_controller_sees_is_what_the_observer_beside_the_loop_estimates() -> None:
    """One set of equations at two places: they differ by the tendons' inverse, quick outside and plain within.

    That is a last bit of a length, 4e−16, of which the gains make at most 1e4.
    """
    prepared = prepare("paper-noisy", "high_gain", {**CLOSED, **SHORT})
    traces = recorded(prepared, compile_loop(prepared.loop), ["high_gain"])
    inside = dict(zip(prepared.loop.truth.x, traces["truth"].x.T, strict=True))
    (block,) = (b for b in prepared.loop.observers if b.name == "high_gain")
    for name, outside in zip(block.x, traces["high_gain"].x.T, strict=True):
        np.testing.assert_allclose(inside[f"eyes.high_gain.{name}"], outside, rtol=0, atol=4e-12, err_msg=name)


def test_an_observer_of_ones_own_closes_the_loop_as_the_registered_one_with_its_equations() -> None:
    mine = dataclasses.replace(OBSERVERS["high_gain"].block(), name="mine")
    closed = {DELTA: "estimated", **SHORT}
    runs = [
        hillobs.simulate("paper-noisy", observer, {**closed, FEEDBACK: name})
        for observer, name in ((mine, "mine"), ("high_gain", "high_gain"))
    ]
    np.testing.assert_array_equal(runs[0].x.values, runs[1].x.values)
    swept = hillobs.sweep("paper-noisy", {"mine.eps_h": [0.1, 0.2]}, 2, [mine], {**closed, FEEDBACK: "mine"})
    assert swept.plant_failed_at.isnull().all()
    assert not (swept.rmse.isel({"mine.eps_h": 0}) == swept.rmse.isel({"mine.eps_h": 1})).any()


def test_an_observer_of_ones_own_that_is_not_there_closes_nothing() -> None:
    with pytest.raises(ScenarioError, match=r"controller\.feedback must be one of states, high_gain"):
        prepare("paper-noisy", "high_gain", {FEEDBACK: "mine"})


def test_each_seed_has_a_truth_of_its_own_and_no_other_run_changes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    planned = plan("paper-noisy", {}, 40, ["high_gain"], {**CLOSED, **SHORT})
    assert planned.loop.noisy
    compiled, numbers = compile_loop(planned.loop), planned.numbers(np.arange(40))
    many = compiled.batch(planned.prepared.grid, planned.seeds, numbers, ["high_gain"])["high_gain"].sums
    few = compiled.batch(
        planned.prepared.grid, planned.seeds[7:10], {k: v[7:10] for k, v in numbers.items()}, ["high_gain"]
    )
    np.testing.assert_array_equal(few["high_gain"].sums, many[7:10])
    assert len({row.tobytes() for row in many}) == 40
    # so a library of its own pays as soon as where the plant differs
    monkeypatch.setattr(planning, "PAYS", 0)
    assert (again := dataclasses.replace(planned)).loop is not again.prepared.loop


@pytest.mark.chaos
@pytest.mark.parametrize("observer", BY_ANOTHER)
def test_tracking_is_that_of_another_program(observer: str) -> None:
    """To its two digits without noise, to the spread of seeds with it."""
    clean, noisy = BY_ANOTHER[observer]
    assert tracking(hillobs.simulate("paper-clean", changes={FEEDBACK: observer})) == pytest.approx(clean, rel=0.05)
    for seed in range(3):
        run = hillobs.simulate("paper-noisy", changes={FEEDBACK: observer, DELTA: "estimated", "seed": seed})
        assert tracking(run) == pytest.approx(noisy, rel=0.25)


@pytest.mark.chaos
@pytest.mark.parametrize("observer", OBSERVERS)
@pytest.mark.parametrize("Delta", ["known", "estimated", "estimated with rate"])
def test_no_observer_loses_the_plant(observer: str, Delta: str) -> None:
    """From a start that is ten times as wrong too."""
    try:
        prepare("paper-noisy", None, {FEEDBACK: observer, DELTA: Delta})
    except ScenarioError:
        assert Delta == "estimated with rate"
        return
    for start in ({}, {"initial.x1_hat": 2.8, "initial.x3_hat": 1.938}):
        run = hillobs.simulate("paper-noisy", changes={FEEDBACK: observer, DELTA: Delta, **start})
        assert run.x.notnull().all()
        assert tracking(run) < 0.05


def test_peaks_of_an_observer_do_not_reach_the_controller() -> None:
    bounded, free = ({f"feedback.{name}_max": most for name in ("x2", "Delta")} for most in (0.01, 10))
    run, freer = (hillobs.simulate("paper-noisy", changes={**CLOSED, **SHORT, **most}) for most in (bounded, free))
    assert abs(run.Delta_hat.sel(observer="high_gain")).max() > 0.1
    active, never = (json.loads(each.attrs["guards"])["truth"] for each in (run, freer))
    assert min(active["feedback.Delta_limit"], active["feedback.x2_limit"]) > 0.1
    assert not {"feedback.Delta_limit", "feedback.x2_limit"} & set(never)
    block, given = saturation(), {"x2_hat": -3.0, "Delta_hat": 0.7}
    function = ca.Function("f", [block.u.vector(), block.p.vector()], [block.y.vector()])
    numbers = [parameter.default for parameter in block.parameters.values()]
    told = np.array(function([given.get(name, 2.0) for name in block.u], numbers)).ravel()
    assert dict(zip(block.y, told, strict=True)) == {**dict.fromkeys(block.u, 2.0), "x2_hat": -0.2, "Delta_hat": 0.2}


@pytest.mark.parametrize(
    ("scenario", "changes", "words"),
    [
        ("paper-noisy", {DELTA: "estimated"}, "needs an observer that estimates it"),
        ("paper-noisy", {FEEDBACK: "high_gain", DELTA: "estimated with rate"}, "high_gain does not"),
        ("activation", {FEEDBACK: "high_gain"}, "needs a controller"),
        ("paper-noisy", {FEEDBACK: "nobody"}, "must be one of states, high_gain"),
        ("paper-noisy", {FEEDBACK: "kalman", "noise.period": 0.0}, "names moves at samples only"),
        ("arm", {FEEDBACK: "high_gain"}, "controller.feedback"),
    ],
)
def test_what_cannot_be_closed_is_refused(scenario: str, changes: dict[str, str], words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        prepare(scenario, None, changes)


def test_a_page_has_one_plant_for_all_seeds(tmp_path) -> None:
    with pytest.raises(ScenarioError, match=r"controller\.feedback must be states"):
        export_page("paper-noisy", path=tmp_path / "page.html", changes=CLOSED)


def part(name: str, start: Callable[[Symbols], object]) -> Block:
    x, u = symbols("x"), symbols("u")
    return Block(name, x=x, u=u, dx=Symbols(x=u.u), x0=Symbols(x=start(u)), y=Symbols(x=x.x))


def test_a_start_may_follow_from_that_of_another_part() -> None:
    """As that of an observer which starts at what it measures of a plant that starts somewhere."""
    first, second = part("first", lambda u: 3 + u.u), part("second", lambda u: 2 * u.u)
    wired = wire("both", [first, second], {"first.u": "w", "second.u": "first.x"}, {"w": "held"})
    assert float(ca.Function("x0", [wired.u.w], [wired.x0["second.x"]])(0.5)) == 2 * (3 + 0.5)
    with pytest.raises(BlockError, match="both: states whose starts depend on each other"):
        wire("both", [first, second], {"first.u": "second.x", "second.u": "first.x"})


def test_the_report_says_whose_estimates_the_controller_takes() -> None:
    run = hillobs.simulate("paper-noisy", changes={**CLOSED, **SHORT})
    late = run.time >= SHORT["score.start"]
    off = float(abs(run.x.sel(state="x1") - run.r).where(late).max())
    words = f"x1 is within {off:.2g} of its reference from τ = 0.2 on"
    assert f"{words}, with the controller on the estimates of HGO" in list(notes(run))
    assert f"{words}" in list(notes(run.assign_attrs(choices=json.dumps({"plant.drive": "virtual"}))))
    lost = run.assign(x=run.x.where(run.time < 0.5))
    assert any(sentence.startswith("x1 is within") for sentence in notes(lost))
    assert not any(sentence.startswith("x1 is within") for sentence in notes(run.assign(x=run.x * np.nan)))
