"""Gains of observers by search: what is tuned, on which runs, and what is refused."""

import dataclasses
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hillobs
from command_line import in_a_process
from hillobs.observers import OBSERVERS
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.simulate.run import simulate
from hillobs.studies.sweep.axes import Range
from hillobs.studies.sweep.computing import on_threads
from hillobs.studies.tune.candidates import rounded
from hillobs.studies.tune.ranges import SPAN, usual_ranges
from hillobs.studies.tune.run import Tuned, tune
from hillobs.studies.tune.task import Task, task
from hillobs.studies.tune.trajectories import trajectories

SHORT = {"duration": 1.0, "score.start": 0.5, "step": 1e-3}


def asked(observer: str, source: str = "paper-noisy", over: dict[str, Range] | None = None, **changes: float) -> Task:
    return task(source, observer, None, over or {}, 50, 2, {**SHORT, **changes}, False, on_threads(1))


@pytest.fixture(scope="module")
def found() -> Tuned:
    return tune("paper-noisy", "high_gain", ["x2", "u1,u2"], trials=50, seeds=1, changes=SHORT)


def test_the_numbers_found_are_those_of_a_trial_and_run(found: Tuned) -> None:
    best = found.trials.isel(trial=found.trials.attrs["best"])
    assert dict(zip(best.path.values.tolist(), best.number.values.tolist(), strict=True)) == found.numbers
    assert best.front.item()
    assert best.broken.item() == 0
    alone = simulate("paper-noisy", "high_gain", {**SHORT, **found.numbers, "seed": int(found.tests.seed[0])})
    np.testing.assert_array_equal(
        found.tests.rmse.sel(gains="tuned").isel(trajectory=0, seed=0),
        alone.rmse.sel(estimator="high_gain", quantity=found.tests.quantity.values),
    )


def test_the_factor_is_the_geometric_mean_over_the_training_runs(found: Tuned) -> None:
    made = asked("high_gain")
    best = found.trials.number.values[[found.trials.attrs["best"]]]
    errors = [made.candidates.errors(n, made.training, made.plan.seeds[:1]) for n in (best, made.own[None])]
    ratio = xr.DataArray(errors[0] / errors[1], dims=("trial", "trajectory", "seed", "quantity"))
    ratio["quantity"] = list(made.plan.quantities)
    for objective, names in {"x2": ["x2"], "u1, u2": ["u1", "u2"]}.items():
        factor = found.trials.factor.sel(objective=objective)[found.trials.attrs["best"]].item()
        assert factor == pytest.approx(float(np.exp(np.log(ratio.sel(quantity=names)).mean())), rel=1e-12)


def test_tests_have_other_noise_and_other_trajectories_than_training() -> None:
    made = asked("high_gain")
    assert not set(made.test_seeds.tolist()) & set(made.plan.seeds.tolist())
    own, *training = made.training.values.tolist()
    own_again, *tests = made.tests.values.tolist()
    assert own == own_again
    assert not any(trajectory in training for trajectory in tests)


def test_trajectories_are_the_sines_within_their_spread() -> None:
    prepared = prepare("slack", "high_gain", {})
    drawn = trajectories(prepared, 200, 5)
    # the pulses of this scenario, which have amplitudes too, are left as they are
    assert drawn.paths == (
        "uncertainty.amplitude",
        "uncertainty.frequency",
        "reference.amplitude",
        "reference.frequency",
    )
    factors = drawn.values[1:] / drawn.values[0]
    assert factors.min() >= 1 / 1.5
    assert factors.max() <= 1.5
    # log-uniform: the mean of 200 logarithms is within 4 of its standard deviations, ln 1.5/√(3·200)
    assert np.abs(np.log(factors).mean(axis=0)).max() < 4 * math.log(1.5) / math.sqrt(600)


def test_a_number_that_an_equation_fixes_follows() -> None:
    """α₀ = 2√(2β₀) of the adaptive observer."""
    made = asked("adaptive_sliding_mode")
    assert "adaptive_sliding_mode.alpha0" not in made.ranges
    numbers = np.vstack([made.own, made.own])
    numbers[1, list(made.ranges).index("adaptive_sliding_mode.beta0")] = 1.3
    axes = made.candidates.axes(numbers)
    alpha0 = axes.values[axes.paths.index("adaptive_sliding_mode.alpha0")]
    np.testing.assert_allclose(alpha0, 2 * np.sqrt(2 * np.array([1.1, 1.3])), rtol=1e-14)
    assert made.candidates.broken(numbers).tolist() == [0.0, 3.0]  # a < 1/β₀, once for each trajectory


def test_ranges_are_about_the_scenarios_numbers_and_within_their_bounds() -> None:
    prepared = prepare("paper-noisy", "sliding_mode", {"sliding_mode.tau_s": 0.05})
    ranges = usual_ranges(prepared, prepared.chosen["sliding_mode"], "sliding_mode")
    assert "sliding_mode.m" not in ranges
    span = ranges["sliding_mode.tau_s"]
    assert (span.low, span.high, span.logarithmic) == (0.05 / SPAN, 0.05 * SPAN, True)


def test_a_range_stays_below_what_is_no_value_and_within_all_numbers() -> None:
    prepared = prepare("paper-noisy", "high_gain", {"high_gain.h11": 1e30, "high_gain.h12": 1e-30})
    ranges = usual_ranges(prepared, prepared.chosen["high_gain"], "high_gain")
    assert ranges["high_gain.h11"].high <= 1e30
    assert ranges["high_gain.h12"].low >= 1e-30


def test_of_ones_own_observer_its_own_positive_numbers_are_tuned() -> None:
    """Not the guards of what is wired behind it, nor where it starts, nor what it shares with the plant."""
    mine = dataclasses.replace(OBSERVERS["levant"].block(), name="mine")
    prepared = prepare("paper-noisy", mine, {})
    ranges = usual_ranges(prepared, prepared.chosen["mine"], "mine")
    assert list(ranges) == [f"mine.{number}" for number in ("L_D", "L_u1", "L_u2", "eps_h", "eps_L")]


def test_without_noise_one_seed_tells_all() -> None:
    made = asked("high_gain", "paper-clean")
    assert (len(made.plan.seeds), len(made.test_seeds)) == (1, 1)


def test_joints_and_muscles_of_a_mechanism_have_one_number_each() -> None:
    prepared = prepare("hinge", "high_gain", {})
    ranges = usual_ranges(prepared, prepared.chosen["high_gain"], "high_gain")
    assert list(ranges) == [
        *(f"high_gain.joint.{h}" for h in ("h11", "h12", "h13")),
        *(f"high_gain.muscle.{h}" for h in ("h21", "h22")),
    ]


def test_digits_of_what_is_tried_are_few() -> None:
    assert rounded(np.array([[0.123456, 12345.6], [-1e-9 / 3, 0.0]])).tolist() == [
        [0.1235, 12350.0],
        [-3.333e-10, 0.0],
    ]


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"quantities": ["x9"]}, "unknown quantity 'x9'"),
        ({"quantities": ["x2", "x1,x2"]}, "a quantity is named twice"),
        ({"quantities": []}, "at least one quantity"),
        ({"quantities": 3}, "quantities must be a list of objectives, not 3"),
        ({"quantities": [None]}, "an objective is the name of a quantity, or several, not None"),
        ({"observer": ["high_gain", "kalman"]}, "a search is of one observer, not"),
        ({"observer": None}, "a search is of one observer, not None"),
        (
            {"observer": "adaptive_sliding_mode", "over": {"adaptive_sliding_mode.alpha0": Range(1, 2)}},
            "adaptive_sliding_mode.alpha0 follows from other numbers by a gain condition; tune those",
        ),
        ({"quantities": "x2"}, "quantities must be a list of objectives, not 'x2'"),
        ({"trials": 10**6}, "trials must be"),
        ({"quantities": ["x2", ""]}, "unknown quantity ''"),
        ({"over": {"high_gain.eps_h": Range(0.1, 0.2, 3)}}, "a search needs a range without a number of values"),
        ({"over": {"high_gain.eps_h": [0.1, 0.2]}}, "a search needs a range"),
        ({"over": {"high_gain.eps_h": Range(0.2, 0.1)}}, "is empty"),
        ({"over": {"high_gain.eps_h": Range(-1.0, 0.1)}}, "high_gain.eps_h must be above 0, not -1"),
        ({"over": {"high_gain.h99": Range(0.1, 1)}}, "unknown path 'high_gain.h99'"),
        ({"over": {"sliding_mode.tau_s": Range(0.1, 1)}}, "changes nothing here"),
        ({"trials": 0}, "trials must be"),
        ({"seeds": 0}, "seeds must be"),
        ({"changes": {**SHORT, "high_gain.eps_h": 2e-4}}, "fails with the scenario's own gains"),
        (
            {"observer": "adaptive_sliding_mode", "over": {"adaptive_sliding_mode.a_dual": Range(1.5, 2.0)}},
            "none of 50 trials fulfils all gain conditions without a failure; most often broken: 0 < a < 1/β₀",
        ),
    ],
)
def test_mistakes_are_told(given: dict[str, object], sentence: str) -> None:
    call = {"source": "paper-noisy", "observer": "high_gain", "trials": 50, "seeds": 1, "changes": SHORT, **given}
    with pytest.raises(hillobs.ScenarioError, match=sentence):
        tune(**call)


def test_the_command_writes_a_scenario_that_runs_a_figure_and_the_trials(tmp_path: Path) -> None:
    words = ["tune", "--observer", "kalman_constant", "--trials", "50", "--seeds", "1", "--out", str(tmp_path)]
    words += [word for path, value in SHORT.items() for word in ("--set", f"{path}={value}")]
    done = in_a_process("-m", "hillobs", *words)
    assert (done.returncode, done.stderr) == (0, "")
    assert "KF const: s_D = " in done.stdout
    stem = "tuned-paper-noisy,duration=1,score.start=0.5,step=0.001,kalman_constant"
    assert sorted(path.name for path in tmp_path.iterdir() if path.name[0] != ".") == [
        f"{stem}-search.png",
        f"{stem}.toml",
        f"{stem}.trials",
    ]
    gains = tomllib.loads((tmp_path / f"{stem}.toml").read_text())
    assert gains["base"] == "paper-noisy"
    assert set(gains["kalman_constant"]) == {"s_D", "s_u1", "s_u2"}
    assert simulate(tmp_path / f"{stem}.toml", "kalman_constant").rmse.notnull().all()
    # the same command has nothing left to try, and says the same
    assert in_a_process("-m", "hillobs", *words).stdout == done.stdout


def test_without_the_extra_it_says_what_to_install() -> None:
    words = "import sys; sys.modules['optuna'] = None; from hillobs.__main__ import main; main()"
    done = in_a_process("-c", words, "tune", "--observer", "high_gain")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "hillobs: tuning needs Optuna: pip install 'hillobs[tune]'\n"
