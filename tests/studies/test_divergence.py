"""What diverges has a time and a cause and no scores, in every study; what is healthy is never taken for it."""

import dataclasses
import itertools
import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from hillobs.model.block import Block, BlockError, Parameter, Symbols
from hillobs.observers import OBSERVERS, estimator
from hillobs.observers.high_gain import LIMIT
from hillobs.studies.cli.reports.number import number
from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.scores import scores
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.simulate.run import RunWarning, simulate
from hillobs.studies.sweep.run import sweep
from places import OF_THE_PAIR, RECORDINGS

pytestmark = pytest.mark.numerics

H, C = 5e-4, 5.54
LONG = {"duration": 6.0, "score.start": 1.0, "step": H}
# injections with the wrong sign: linear ones make an error grow as exp(t/ε), those that saturate push it away for ever
NEGATIVE = {
    "high_gain": {"h11": -3.0, "h12": -3.0, "h13": -1.0, "h21": -2.0, "h22": -1.0, "h31": -2.0, "h32": -1.0},
    "high_gain_3": {"h11": -3.0, "h13": -1.0, "h21": -3.0, "h23": -1.0, "h32": -3.0, "h33": -1.0},
    "sliding_mode": {"lambda11": -28.0, "alpha2": -10.0, "alpha3": -10.0},
    "adaptive_sliding_mode": {"alpha0": -30.0, "eta1": -30.0, "eta2": -30.0},
}
# there a rate is the root of a negative number: a simulation has its step anyway, a recording is refused
NO_RATE = {"sliding_mode": "alpha11", "adaptive_sliding_mode": "beta0"}
# h times a rate beyond the 2.79 up to which RK4 is stable
FAST = {
    "high_gain": {"eps_h": H / 2.9},
    "high_gain_3": {"eps_h": H / 2.9},
    "sliding_mode": {"tau_s": H / 5},
    "adaptive_sliding_mode": {"tau_a": H / 5},
}
GAINS = [(name, gain, value) for name, gains in NEGATIVE.items() for gain, value in gains.items()]
ROOTS = [(name, gain, -10.0) for name, gain in NO_RATE.items()]
STEPS = [(name, gain, value) for name, gains in FAST.items() for gain, value in gains.items()]
# some begin with what is measured
STARTS = [
    (name, start, 1e25)
    for name, observer in OBSERVERS.items()
    for start in ("initial.x1_hat", "initial.x2_hat", "initial.x4_hat")
    if start in observer.block().parameters
]


def path(observer: str, gain: str) -> str:
    return f"{observer}.{gain}"


@pytest.mark.parametrize(("observer", "gain", "value"), [*GAINS, *ROOTS, *STEPS, *STARTS], ids=lambda value: str(value))
def test_a_simulation_and_a_sweep_name_what_diverges(observer: str, gain: str, value: float) -> None:
    changes = {**LONG, path(observer, gain): value}
    run = simulate("paper-clean", observer, changes)
    swept = sweep("paper-clean", {path(observer, gain): [value]}, 1, observer, LONG).squeeze()
    said = json.loads(run.attrs["failures"])
    assert list(said) == [observer]
    cause = str(swept.failure.attrs["flag_meanings"]).split()[int(swept.failure)]
    assert said[observer].startswith(f"{observer}: {cause} is not a number within ±")
    assert f"at τ = {float(swept.failed_at):g}; " in said[observer]
    # no measure of either, no estimate from then on, and none before that its kind does not allow
    assert swept.rmse.isnull().all()
    assert run.rmse.sel(estimator=observer).isnull().all()
    assert run.rmse.sel(estimator="baseline").notnull().all()
    lived = run.time.values < float(swept.failed_at)
    assert run.x_hat.isnull().values[0, ~lived].all()
    for name, order in (("x1", 0), ("x2", 1), ("x3", 0), ("x4", 0)):
        assert np.all(np.abs(run.x_hat.sel(state=name).values[0, lived]) <= 2 * C * (2.5 / H) ** order)


@pytest.mark.parametrize(("observer", "gain", "value"), GAINS, ids=lambda value: str(value))
def test_an_estimate_names_what_diverges(observer: str, gain: str, value: float, shipped_recording: Recording) -> None:
    others = [name for name in ("high_gain", "sliding_mode") if name != observer]
    estimates = estimate(
        shipped_recording, RECORDINGS / "dgf_smooth.toml", [observer, *others], changes={path(observer, gain): value}
    )
    said = json.loads(estimates.attrs["failures"])
    assert list(said) == [observer]
    assert "_hat is not a number within ±" in said[observer]
    at = float(said[observer].partition(" at ")[2].partition(" s;")[0])
    of = estimates.sel(observer=observer)
    lost = np.isnan(of.velocity_hat.values)
    assert estimates.time.values[lost.argmax()] == pytest.approx(at, rel=1e-3)
    assert lost[lost.argmax() :].all()
    assert np.isnan(of.activation_hat.values[lost]).all()
    assert not of.activation_limited.values[lost].any()
    table = {(score.observer, math.isnan(score.rmse), math.isnan(score.peak)) for score in scores(estimates)}
    assert table == {(observer, True, True), *((name, False, False) for name in others)}


@pytest.mark.parametrize(("observer", "gain", "value"), ROOTS, ids=lambda value: str(value))
def test_gains_without_a_rate_are_refused(observer: str, gain: str, value: float, shipped_recording: Recording) -> None:
    with pytest.raises(ScenarioError, match=f"the gains of {observer} make no observer: its rate .*√.* is no number"):
        estimate(shipped_recording, RECORDINGS / "dgf_smooth.toml", observer, changes={path(observer, gain): value})


@pytest.fixture(scope="module")
def shipped_recording() -> Recording:
    return read_recording(RECORDINGS / "dgf_smooth_noisy.csv.gz")


def test_observers_are_known_until_the_truth_fails() -> None:
    """The truth is computed some steps ahead of them."""
    far = {"duration": 1.0, "score.start": 0.5, "reference.offset": 0.0}
    with pytest.warns(RunWarning, match=r"the plant failed at τ = 0\.\d+") as told:
        run = simulate("paper-noisy", changes=far)
    failed = float(str(told[0].message).partition(" = ")[2].partition(";")[0])
    before = (run.time < failed).values
    assert 10 < before.sum() < len(before)
    assert (run.x_hat.notnull().all(["observer", "state"]).values == before).all()


def test_an_observer_of_ones_own_may_set_limits(proportional: Block) -> None:
    bounded = dataclasses.replace(proportional, limits=Symbols(x1_hat=ca.SX(2.0)))
    said = json.loads(simulate("paper-clean", bounded, LONG).attrs["failures"])
    assert said == {"proportional": "proportional: x1_hat is not a number within ±2 at τ = 0; it starts there"}
    with pytest.raises(BlockError, match="limits names x9; valid are x1_hat"):
        dataclasses.replace(proportional, limits=Symbols(x9=ca.SX(2.0)))
    with pytest.raises(BlockError, match=r"limits.x1_hat uses x1_hat, not among"):
        dataclasses.replace(proportional, limits=Symbols(x1_hat=proportional.x.x1_hat))


def test_a_length_of_ones_own_is_not_taken_for_the_domain(proportional: Block) -> None:
    C = Symbols(C=ca.SX.sym("C"))
    known = {"a1_hat": ca.SX(0.5), "a2_hat": ca.SX(0.5)}
    own = dataclasses.replace(
        proportional,
        p=Symbols({**proportional.p, **C}),
        parameters={**proportional.parameters, "C": Parameter(1.0, "a gain", "this test")},
        y=Symbols({**proportional.y, **known}),
    )
    with pytest.raises(BlockError, match="the domain wired to it has a parameter C too"):
        estimator(own)


@pytest.mark.parametrize("scenario", OF_THE_PAIR)
def test_no_shipped_scenario_diverges(scenario: str) -> None:
    assert json.loads(simulate(scenario, list(OBSERVERS)).attrs["failures"]) == {}


def test_no_shipped_sweep_diverges() -> None:
    """Those of the README: each at the ends of its ranges, all corners."""
    wide = sweep("paper-noisy", {"high_gain.eps_h": [0.02, 0.1, 0.5], "noise.x1": [1e-5, 1e-2]}, 2, list(OBSERVERS))
    heavy = sweep("paper-noisy", {"plant.m": [0.8, 1.0, 1.2]}, 2, list(OBSERVERS))
    for swept in (wide, heavy):
        assert swept.failed_at.isnull().all()
        assert swept.plant_failed_at.isnull().all()
        assert swept.rmse.notnull().all()


@pytest.mark.parametrize("step", [5e-3, 5e-4, 5e-5])
def test_no_peak_of_the_fastest_gains_is_taken_for_divergence(step: float) -> None:
    """From every corner of the domain, with the smallest ε that the gain conditions allow."""
    corners = np.array(list(itertools.product((0.0, C), (-1.0, 1.0), (0.0, C), (0.0, C)))).T
    over = dict(zip((f"initial.x{i}_hat" for i in range(1, 5)), corners, strict=True))
    fastest = {f"{name}.eps_h": 1.001 * step / LIMIT for name in ("high_gain", "high_gain_3")}
    changes = {**fastest, "step": step, "duration": 400 * step, "record": step, "score.start": 0.0, "noise.period": 0}
    swept = sweep("paper-clean", over, 1, ["high_gain", "high_gain_3"], changes, kind="zip")
    assert "high_gain" not in json.loads(swept.attrs["violated_conditions"])
    assert swept.failed_at.isnull().all()
    # peaks there are: as large as the domain, and Δ̂ far larger
    assert float(swept.peak.sel(quantity="Delta").max()) > 0.01 / step**2


def test_the_gains_of_the_rule_satisfy_the_theorems(shipped_recording: Recording) -> None:
    estimates = estimate(shipped_recording, RECORDINGS / "dgf_smooth.toml", list(OBSERVERS))
    assert json.loads(estimates.attrs["violated_conditions"]) == {}
    assert json.loads(estimates.attrs["failures"]) == {}


@pytest.mark.parametrize(
    ("changes", "condition"),
    [
        ({"high_gain.h13": 10.0}, "h₁₁h₁₂ > h₁₃: 9 > 10 does not hold"),
        ({"high_gain.eps_h": 1.5}, "0 < ε_h < 1: 1.5 < 1 does not hold"),
        ({"sliding_mode.lambda11": 0.1}, "[lambda11]: 0.1 > "),
        ({"sliding_mode.alpha2": 0.01}, "α₂ > U₁ₘ [alpha2]: 0.01 > "),
        ({"adaptive_sliding_mode.a_dual": 1.0}, "0 < a < 1/β₀: 1 < 0.9090909 does not hold"),
    ],
)
def test_gains_by_hand_are_held_against_the_theorems(
    changes: Mapping[str, float], condition: str, shipped_recording: Recording
) -> None:
    (given_path,) = changes
    observer = given_path.partition(".")[0]
    estimates = estimate(shipped_recording, RECORDINGS / "dgf_smooth.toml", observer, changes=changes)
    (sentence,) = json.loads(estimates.attrs["violated_conditions"])[observer]
    assert condition in sentence


@settings(max_examples=200)
@given(st.floats())
def test_every_number_can_be_printed(value: float) -> None:
    text = number(value)
    # two digits; the largest number of all is rounded up, beyond itself
    if math.isnan(value):
        assert text == "–"
    else:
        assert abs(value) > 1.7e308 or float(text) == pytest.approx(value, rel=0.06)


@pytest.mark.parametrize("value", [1e31, -1e300, 1e-31, -1e-300, 1e308])
@pytest.mark.parametrize("where", ["plant.m", "high_gain.eps_h", "initial.x1_hat"])
def test_a_number_that_no_quantity_has_is_refused(where: str, value: float) -> None:
    # below 0 the bound of the number itself is told
    sentence = f"{where} must be (0 or from 1e-30 to 1e\\+30 in magnitude|above 0)"
    with pytest.raises(ScenarioError, match=sentence):
        simulate("paper-clean", changes={where: value})
    with pytest.raises(ScenarioError, match=sentence):
        sweep("paper-clean", {where: [value]})


@pytest.mark.parametrize("change", ["plant.m=1e30", "plant.m=1e-30", "high_gain.eps_h=1e30", "initial.x1_hat=-1e30"])
def test_the_extremes_are_told_without_a_warning(change: str, command: Callable[..., tuple[int, str, str]]) -> None:
    name, _, value = change.partition("=")
    short = ["paper-noisy", "--observer", "high_gain", "--set", "duration=0.5", "--set", "score.start=0.1"]
    for call in (
        ["simulate", *short, "--set", change, "--no-figures", "--out", "results"],
        ["sweep", *short, "--over", f"{name}={value}"],
        ["sweep", *short, "--over", f"{name}={value},1", "--quantity", "x2", "--out", "x.nc"],
    ):
        code, _, err = command(*call)
        assert code in (0, 1)
        assert "warning" not in err


SHIPPED, MUSCLES = str(RECORDINGS / "dgf_smooth_noisy.csv.gz"), str(RECORDINGS / "dgf_smooth.toml")
RUNS = {
    "simulate": (["simulate", "paper-clean", "--set", "duration=1", "--no-figures"], "results"),
    "sweep": (["sweep", "paper-clean", "--set", "duration=2.1", "--out", "x.nc", "--no-figures"], "."),
    "estimate": (
        ["estimate", SHIPPED, "--muscles", MUSCLES, "--no-figures"],
        "estimates",
    ),
}


@pytest.mark.parametrize("verb", RUNS)
def test_what_cannot_be_printed_is_written(
    verb: str, command: Callable[..., tuple[int, str, str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*_: object) -> None:
        raise ZeroDivisionError("a table that cannot be printed")

    monkeypatch.setattr("rich.table.Table.add_row", failing)
    arguments, folder = RUNS[verb]
    with pytest.raises(ZeroDivisionError):
        command(*arguments)
    (result,) = (tmp_path / folder).glob("*.nc")
    assert xr.open_dataset(result, engine="h5netcdf").sizes["observer"] == 3
