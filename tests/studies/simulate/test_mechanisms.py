"""Simulated mechanisms: an elbow with two muscles, compiled once, in all that is made of a run."""

import json
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import xarray as xr

from hillobs.codegen.stepper import functions
from hillobs.studies.cli.reports.simulate import notes, tables
from hillobs.studies.figures.run import FIGURES, figures
from hillobs.studies.files.datasets.netcdf import load
from hillobs.studies.files.errors import ResultError
from hillobs.studies.laboratory.recording import read_recording
from hillobs.studies.laboratory.subject import subject_of
from hillobs.studies.observability.question import pose
from hillobs.studies.scenarios.layers import Value
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.simulate.files import save
from hillobs.studies.simulate.run import RunWarning, simulate
from hillobs.studies.simulate.schema import check_run
from hillobs.studies.sweep.run import sweep
from places import RECORDINGS

HINGE = RECORDINGS / "hinge_pair.toml"
SHORT: dict[str, Value] = {"duration": 3.0, "score.start": 1.0}
OBSERVER = "high_gain"


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    """Three reference times of the shipped scenario."""
    return simulate("hinge", OBSERVER, SHORT)


def test_the_compiled_truth_is_that_of_casadi(run: xr.Dataset) -> None:
    """Stage by stage against whole steps in CasADi's machine: rounding of 3,000 steps, which damped joints forget."""
    prepared = prepare("hinge", OBSERVER, SHORT)
    truth, h = prepared.loop.truth, prepared.grid.h
    table, p = functions(truth, (), ()), prepared.paths.values(truth, prepared.scenario.given)
    x = table["init"](0, p, [], [])
    for k in range(prepared.grid.steps):
        x, _ = table["step"](k * h, h, x, p, [], ca.DM(0, 4))
    np.testing.assert_allclose(run.x.isel(time=-1), np.array(x).ravel(), rtol=1e-11)


def test_a_step_out_of_stages_is_a_step() -> None:
    truth = prepare("hinge", OBSERVER, SHORT).loop.truth
    table = functions(truth, (), ())
    p = prepare("hinge", OBSERVER, SHORT).paths.values(truth, {})
    x, t, h = np.array(table["init"](0, p, [], [])), 0.7, 1e-3
    after, seen = table["step"](t, h, x, p, [], ca.DM(0, 4))
    dx, total = np.zeros_like(x), x.copy()
    for node, weight in ((0, 1 / 6), (0.5, 1 / 3), (0.5, 1 / 3), (1, 1 / 6)):
        dx = np.array(table["stage"](t, h, node, x + node * dx, p, [], [])[0])
        total = total + weight * dx
    np.testing.assert_allclose(np.array(after), total, rtol=1e-14)
    assert seen.is_empty()


def test_a_run_has_the_names_of_joints_and_muscles(run: xr.Dataset, tmp_path: Path) -> None:
    assert run.state.values.tolist() == ["elbow.q", "elbow.dq", "TRIlat.L_S", "BRA.L_S"]
    assert run.muscle.values.tolist() == ["TRIlat", "BRA"]
    assert run.joint.values.tolist() == ["elbow"]
    assert run.place.values.tolist() == ["elbow"]
    check_run(run)
    save(run, tmp_path)
    again = load(tmp_path / f"{run.attrs['run']}.nc")
    check_run(again)
    assert again.equals(run)


def test_what_is_told_of_a_run_is_of_the_mechanism(run: xr.Dataset) -> None:
    (_, table), *_ = tables(run)
    assert [column.header for column in table.columns][1:] == run.quantity.values.tolist()
    told = "\n".join(notes(run))
    assert "elbow is within" in told
    assert "in units of TRIlat: lengths 0.1138 m, forces 624.3 N, time 0.1 s" in told
    assert set(figures(run)) == set(FIGURES)
    # a plant that fails later is told of up to there, one that fails at once is nowhere
    for failed, words in ((run.time > 0.5 * float(run.time[-1]), True), (run.time >= 0, False)):
        lost = run.assign({name: run[name].where(~failed) for name in ("x", "at")})
        told = "\n".join(notes(lost))
        assert ("elbow is within" in told) == words
        assert "nan" not in told


@pytest.mark.parametrize(
    "forged",
    [
        lambda run: run.assign_coords(muscle=["TRIlat", "other"]),
        lambda run: run.assign_coords(place=["foot.x"]),
        lambda run: run.assign(muscle_file=((), '{"joints": {}}')),
        lambda run: run.drop_vars("Phi_S"),
        lambda run: run.assign_attrs(scales="{}"),
    ],
    ids=["muscle", "place", "file", "force", "scales"],
)
def test_a_forged_run_is_refused(run: xr.Dataset, forged) -> None:
    with pytest.raises(ResultError, match=r"its |it has no"):
        check_run(forged(run))


def test_the_recording_of_a_run_says_the_same_in_si(run: xr.Dataset, tmp_path: Path) -> None:
    """Positions by the joint's law: what estimates read is measured and true, and d/dt of one is the other."""
    *_, path = save(run, tmp_path)
    subject = subject_of(HINGE)
    recording = read_recording(path, known=subject.columns)
    assert len(recording) == run.sizes["time"]
    np.testing.assert_allclose(recording.time, run.time / 10, rtol=1e-12)
    np.testing.assert_allclose(recording["angle_elbow"], run.y.sel(sensor="elbow.y"), rtol=1e-12)
    np.testing.assert_allclose(recording["force_BRA"], run.y.sel(sensor="BRA.y") * 624.3, rtol=1e-12)
    true = recording.true
    np.testing.assert_allclose(true["activation_BRA"], run.a.sel(muscle="BRA"), rtol=1e-12)
    # fibre and tendon make up the path: TRIlat's fibres are oblique by 9° at l₀ = 0.1138 m
    height = 0.1138 * np.sin(0.15707963)
    along = np.sqrt(true["fibre_length_TRIlat"] ** 2 - height**2)
    np.testing.assert_allclose(true["tendon_length_TRIlat"] + along, true["path_length_TRIlat"], rtol=1e-12)
    # central differences over 5 ms: a thousandth of velocities that change within 50 ms
    rate = np.gradient(true["fibre_length_BRA"], recording.time)[20:-1]
    np.testing.assert_allclose(true["fibre_velocity_BRA"][20:-1], rate, atol=2e-3 * np.abs(rate).max())


def test_a_sweep_has_the_numbers_of_the_runs_to_the_bit(run: xr.Dataset) -> None:
    swept = sweep("hinge", {"high_gain.muscle.eps_L": [0.1, 0.2]}, 2, OBSERVER, SHORT)
    assert swept.sizes == {"sampled": 4, "high_gain.muscle.eps_L": 2, "seed": 2, "observer": 1, "quantity": 9}
    here = swept.rmse.isel(seed=0).sel({"high_gain.muscle.eps_L": 0.1, "observer": OBSERVER})
    assert here.values.tolist() == run.rmse.sel(estimator=OBSERVER).values.tolist()
    # the joint's chain knows nothing of those of muscles
    of_joint = swept.rmse.sel(quantity=["elbow.q", "elbow.dq", "elbow.Delta"])
    assert (of_joint.isel({"high_gain.muscle.eps_L": 0}) == of_joint.isel({"high_gain.muscle.eps_L": 1})).all()
    assert (swept.rmse.sel(quantity="BRA.a").std("high_gain.muscle.eps_L") > 0).all()


def test_a_step_that_does_not_resolve_a_tendon_fails_with_its_cause() -> None:
    with pytest.warns(RunWarning, match="the plant failed at τ = 0"):
        coarse = simulate("hinge", OBSERVER, {**SHORT, "step": 0.05})
    (sentence,) = json.loads(coarse.attrs["failures"]).values()
    assert "a tendon comes to rest at a rate above 50, faster than the step resolves; try a smaller step" in sentence
    assert coarse.rmse.isnull().all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mechanism": "nothing"}, "unknown mechanism 'nothing'; there are arm, dynamometer, hinge_pair"),
        ({"mechanism": "absent.toml"}, "absent.toml: cannot be read"),
        ({"controller.tracks": "hand.x"}, "controller.tracks: 'hand.x' cannot be led; there are elbow"),
        ({"controller.tracks": "elbow, elbow"}, "controller.tracks must be one to 1 places, each once"),
        ({"plant.drive": "steam"}, "plant.drive must be one of requested, virtual, given, excited, not 'steam'"),
        ({"muscle1.k": 3.0}, "unknown path 'muscle1.k'"),
        ({"pulse1.start": 3.0}, "unknown path 'pulse1.start'"),
        ({"BRA.F_max": -1.0}, "BRA.F_max must be above 0"),
    ],
)
def test_what_is_wrong_with_a_mechanisms_scenario_is_said(changes: dict[str, Value], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        prepare("hinge", OBSERVER, changes)


def test_a_mechanisms_file_is_looked_for_beside_its_scenario(tmp_path: Path) -> None:
    (tmp_path / "elbow.toml").write_text(HINGE.read_text(encoding="utf-8"), encoding="utf-8")
    scenario = tmp_path / "mine.toml"
    scenario.write_text('base = "hinge"\nmechanism = "elbow.toml"\n', encoding="utf-8")
    assert prepare(scenario, OBSERVER, {}).scenario.mechanism == prepare("hinge", OBSERVER, {}).scenario.mechanism


def test_what_is_of_the_pair_alone_says_so() -> None:
    with pytest.raises(ValueError, match="KF is an observer of a mass between two muscles"):
        prepare("hinge", "kalman", {})
    with pytest.raises(ValueError, match="hinge is of a mechanism; ask about that by its file, --mechanism"):
        pose(prepare("hinge", OBSERVER, {}))


@pytest.mark.chaos
@pytest.mark.parametrize("drive", ["given", "excited", "virtual"])
def test_each_drive_runs(drive: str) -> None:
    run = simulate("hinge", OBSERVER, {**SHORT, "plant.drive": drive})
    assert json.loads(run.attrs["failures"]) == {}
    assert ("r" in run) == (drive == "virtual")
    # signals of activations are 0.2 + 0.1 sin 0.5τ, and those of excitations are followed late
    if drive == "given":
        np.testing.assert_allclose(run.a.sel(muscle="BRA"), 0.2 + 0.1 * np.sin(0.5 * run.time), rtol=1e-12)


@pytest.mark.chaos
def test_an_arm_draws_an_eight_with_every_observer_and_noise() -> None:
    observers = ["high_gain", "high_gain_3", "sliding_mode", "adaptive_sliding_mode", "kalman_constant", "levant"]
    run = simulate("arm", observers)
    assert json.loads(run.attrs["failures"]) == {}
    late = run.sel(time=slice(40, None))
    assert float(abs(late.r - late["at"]).max()) * 0.134 < 5e-3
    assert ((late.a > 0) & (late.a < 1)).all()
    assert (late.Phi_S > 0).all()
