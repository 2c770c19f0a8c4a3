"""Sweeps: what they vary, that a run does not depend on its company, and that nothing is lost or mixed."""

import dataclasses
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from hillobs.codegen.batch import CompiledLoop
from hillobs.studies import plan as planning
from hillobs.studies import sweep as sweeping
from hillobs.studies.axes import Range, axes, parse_axis
from hillobs.studies.files import ResultError
from hillobs.studies.loops import compile_loop
from hillobs.studies.plan import plan
from hillobs.studies.prepare import prepare
from hillobs.studies.simulate import simulate
from hillobs.studies.sweep import on_threads, sweep, sweep_planned
from hillobs.studies.table import ScenarioError

SHORT = {"duration": 0.2, "score.start": 0.05}
EPS = {"high_gain.eps_h": Range(0.02, 0.5, 5, logarithmic=True)}


def test_a_point_of_a_sweep_is_the_run_of_that_scenario() -> None:
    found = sweep("paper-noisy", {"high_gain.eps_h": [0.05, 0.2], "plant.m": [1.0, 1.3]}, seeds=[3, 9], changes=SHORT)
    assert found.rmse.dims == ("high_gain.eps_h", "plant.m", "seed", "observer", "quantity")
    for eps in (0.05, 0.2):
        for m in (1.0, 1.3):
            alone = simulate("paper-noisy", None, {**SHORT, "high_gain.eps_h": eps, "plant.m": m, "seed": 9})
            point = found.sel({"high_gain.eps_h": eps, "plant.m": m, "seed": 9})
            for measure in ("rmse", "peak", "settling", "chattering"):
                np.testing.assert_array_equal(
                    point[measure].values, alone[measure].sel(estimator=found.observer.values).values
                )


def test_the_trade_off_of_the_high_gain_observer_has_its_optimum_where_it_was_found() -> None:
    """estimation-limit §2: near 0.2 for x₂ and Δ, near 0.1 for u and a; worse on both sides."""
    found = sweep("paper-noisy", {"high_gain.eps_h": Range(0.02, 0.5, 11, logarithmic=True)}, seeds=8)
    median = found.rmse.median("seed").sel(observer="high_gain")
    best = median.idxmin("high_gain.eps_h")
    for quantity, low, high in (("x2", 0.15, 0.3), ("Delta", 0.15, 0.3), ("u1", 0.06, 0.15), ("a1", 0.06, 0.15)):
        assert low <= float(best.sel(quantity=quantity)) <= high
        curve = median.sel(quantity=quantity).values
        assert curve[0] > 1.5 * curve.min() < curve[-1]


@pytest.mark.parametrize("workers", [1, 2, 3, 8])
@pytest.mark.parametrize("part", [1, 7, 64])
def test_threads_and_parts_change_no_bit(workers: int, part: int, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = sweep("paper-noisy", EPS, seeds=7, observers=["high_gain", "sliding_mode"], changes=SHORT)
    monkeypatch.setattr(planning, "PART", part)
    cut = sweep("paper-noisy", EPS, seeds=7, observers=["high_gain", "sliding_mode"], changes=SHORT, workers=workers)
    xr.testing.assert_equal(whole, cut)


@pytest.mark.parametrize("runs", [1, 2, 7, 8, 15, 16, 17, 31, 33])
@pytest.mark.parametrize("order", ["reversed", "shuffled"])
def test_order_and_number_of_runs_change_no_bit(runs: int, order: str) -> None:
    prepared = prepare("paper-noisy", None, SHORT)
    compiled = compile_loop(prepared.loop)
    random = np.random.default_rng(runs)
    numbers = {b.name: np.array(prepared.table.values(b, prepared.scenario.given)) for b in prepared.loop.blocks}
    numbers = {name: row * (1 + 0.01 * random.uniform(-1, 1, (runs, len(row)))) for name, row in numbers.items()}
    other = np.arange(runs)[::-1] if order == "reversed" else random.permutation(runs)
    seeds = np.arange(runs, dtype=np.uint64)
    straight = compiled.batch(prepared.grid, seeds, numbers, prepared.observers)
    moved = compiled.batch(
        prepared.grid, seeds[other], {name: rows[other] for name, rows in numbers.items()}, prepared.observers
    )
    for observer in prepared.observers:
        np.testing.assert_array_equal(straight[observer].sums[other], moved[observer].sums)


def test_sharing_the_truth_changes_no_bit() -> None:
    prepared = prepare("paper-noisy", None, SHORT)
    compiled = compile_loop(prepared.loop)
    numbers = {b.name: np.array(prepared.table.values(b, prepared.scenario.given)) for b in prepared.loop.blocks}
    shared = compiled.batch(prepared.grid, np.arange(40), numbers, prepared.observers)
    odd = np.tile(numbers["truth"], (40, 1))
    odd[-1] *= 1.001
    own = compiled.batch(prepared.grid, np.arange(40), {**numbers, "truth": odd}, prepared.observers)
    for observer in prepared.observers:
        np.testing.assert_array_equal(shared[observer].sums[:-1], own[observer].sums[:-1])


def test_every_lane_agrees_with_the_scalar_library() -> None:
    """Different numbers in each lane: sums ≤ 1e−10; without noise the trajectories ≤ 1e−11."""
    prepared = prepare("paper-noisy", None, {"duration": 2.0, "score.start": 0.5})
    lanes, scalar = compile_loop(prepared.loop), CompiledLoop(prepared.loop, "scalar")
    random = np.random.default_rng(1)
    numbers = {b.name: np.array(prepared.table.values(b, prepared.scenario.given)) for b in prepared.loop.blocks}
    for name in prepared.observers:
        numbers[name] = numbers[name] * (1 + 0.02 * random.uniform(-1, 1, (20, len(numbers[name]))))
    one, other = (c.batch(prepared.grid, np.arange(20), numbers, prepared.observers) for c in (lanes, scalar))
    squares = [i for i, name in enumerate(prepared.loop.score.x) if name.endswith(("squares", "peak"))]
    for observer in prepared.observers:
        np.testing.assert_allclose(one[observer].sums[:, squares], other[observer].sums[:, squares], rtol=1e-10)
    clean = prepare("paper-clean", None, {"duration": 2.0, "score.start": 0.5})
    values = {b.name: clean.table.values(b, clean.scenario.given) for b in clean.loop.blocks}
    runs = [c.run(clean.grid, 0, values, clean.observers) for c in (lanes, scalar)]
    for name in clean.observers:
        np.testing.assert_allclose(runs[0][name].x, runs[1][name].x, rtol=0, atol=1e-11)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e308])
def test_a_number_that_is_none_stays_in_its_lane(bad: float) -> None:
    prepared = prepare("paper-noisy", None, SHORT)
    compiled = compile_loop(prepared.loop)
    n = compiled.compiled.lanes + 3
    numbers = {b.name: np.array(prepared.table.values(b, prepared.scenario.given)) for b in prepared.loop.blocks}
    clean = compiled.batch(prepared.grid, np.arange(n), numbers, prepared.observers)
    for observer in prepared.observers:
        place = list(next(b for b in prepared.loop.observers if b.name == observer).p).index("initial.x1_hat")
        for lane in range(n):
            rows = np.tile(numbers[observer], (n, 1))
            rows[lane, place] = bad
            hurt = compiled.batch(prepared.grid, np.arange(n), {**numbers, observer: rows}, prepared.observers)
            others = np.arange(n) != lane
            # a bounded injection keeps even 1e308 finite
            assert hurt[observer].failed[lane] >= 0 or np.isfinite(bad)
            assert (hurt[observer].failed[others] == -1).all()
            assert np.isnan(hurt[observer].sums[lane]).all() == (hurt[observer].failed[lane] >= 0)
            for name in prepared.observers:
                np.testing.assert_array_equal(hurt[name].sums[others], clean[name].sums[others])


def test_the_step_and_the_duration_can_be_swept() -> None:
    found = sweep("paper-noisy", {"duration": [0.2, 0.4], "step": [5e-4, 1e-3]}, changes={"score.start": 0.05})
    alone = simulate("paper-noisy", None, {"score.start": 0.05, "duration": 0.4, "step": 1e-3})
    np.testing.assert_array_equal(
        found.sel({"duration": 0.4, "step": 1e-3, "seed": 0}).rmse, alone.rmse.sel(estimator=found.observer.values)
    )


def test_axes_can_go_together() -> None:
    found = sweep("paper-clean", {"high_gain.eps_h": [0.1, 0.2], "high_gain.h11": [3, 4]}, kind="zip", changes=SHORT)
    assert found.rmse.dims == ("point", "seed", "observer", "quantity")
    assert found["high_gain.h11"].values.tolist() == [3, 4]


@pytest.mark.parametrize("kind", ["latin", "sobol"])
def test_a_design_fills_the_ranges(kind: str) -> None:
    made = axes({"a": Range(0, 1), "b": Range(0.01, 1, logarithmic=True)}, kind, 64)
    for values, low, high in zip(made.values, (0, 0.01), (1, 1), strict=True):
        assert low <= values.min() < values.max() <= high
    # one sample in each of 64 equal strips
    assert len(np.unique(np.floor(made.values[0] * 64))) == 64


def test_a_range_has_its_ends() -> None:
    (values,) = axes(dict([parse_axis("x=log:0.02:0.5:25")])).values
    assert (values[0], values[-1], len(values)) == (0.02, 0.5, 25)
    np.testing.assert_allclose(values[1:] / values[:-1], (0.5 / 0.02) ** (1 / 24), rtol=1e-12)


@pytest.mark.parametrize(
    ("over", "seeds", "words"),
    [
        ({"high_gain.eps_h": []}, 1, "1 to 1,000,000 values"),
        ({"high_gain.eps_h": Range(0, 1, 3, logarithmic=True)}, 1, "needs ends above 0"),
        ({"high_gain.eps_h": Range(2, 1, 3)}, 1, "is empty"),
        ({"high_gain.eps_g": [1]}, 1, "unknown path"),
        ({"high_gain.eps_h": [0.1, -1]}, 1, "must be above 0"),
        ({"high_gain.eps_h": [0.1, 0.1]}, 1, "a value twice"),
        ({"muscle.k": [19, 40]}, 1, "at muscle.k = 40"),
        ({"step": [5e-4, 3e-4]}, 1, "at step = 0.0003"),
        ({"seed": [1]}, 1, "use seeds"),
        ({}, 0, "at least one seed"),
        ({}, [1, 1], "a seed is there twice"),
        ({}, [-1], "whole numbers from 0"),
    ],
)
def test_what_cannot_be_swept_is_said(over, seeds, words) -> None:
    with pytest.raises(ScenarioError, match=words):
        sweep("paper-clean", over, seeds, changes=SHORT)


class _EndedError(Exception):
    pass


def test_an_interrupted_sweep_goes_on_and_ends_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planning, "PART", 4)
    whole = sweep("paper-noisy", EPS, seeds=4, changes=SHORT, out=tmp_path / "whole.nc")

    def end_after_two(done: int, runs: int) -> None:
        if done >= 8:
            raise _EndedError

    out = tmp_path / "cut.nc"
    with pytest.raises(_EndedError):
        sweep("paper-noisy", EPS, seeds=4, changes=SHORT, out=out, workers=1, progress=end_after_two)
    kept = sorted((tmp_path / "cut.nc.parts").glob("*.part"))
    assert kept
    assert not out.exists()
    computed: list[int] = []
    compute_part = sweeping.compute_part
    monkeypatch.setattr(
        sweeping, "compute_part", lambda w, c, part, p: computed.append(part) or compute_part(w, c, part, p)
    )
    again = sweep("paper-noisy", EPS, seeds=4, changes=SHORT, out=out)
    assert len(computed) == 5 - len(kept)
    xr.testing.assert_identical(whole, again)
    assert out.read_bytes() == (tmp_path / "whole.nc").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cut.nc", "whole.nc"]
    computed.clear()
    xr.testing.assert_identical(whole, sweep("paper-noisy", EPS, seeds=4, changes=SHORT, out=out))
    assert not computed


def _unfinished(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(planning, "PART", 4)

    def end(done: int, runs: int) -> None:
        if done >= 12:
            raise _EndedError

    with pytest.raises(_EndedError):
        sweep("paper-noisy", EPS, seeds=4, changes=SHORT, out=tmp_path / "x.nc", workers=1, progress=end)
    return tmp_path / "x.nc.parts"


def test_a_damaged_part_is_computed_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = sweep("paper-noisy", EPS, seeds=4, changes=SHORT)
    folder = _unfinished(tmp_path, monkeypatch)
    first, second, *_ = sorted(folder.glob("*.part"))
    raw = bytearray(first.read_bytes())
    raw[len(raw) // 2] ^= 1
    first.write_bytes(raw)
    second.write_bytes(second.read_bytes()[:-1])
    (folder / ".00000001.part-torn").write_bytes(b"half")
    with pytest.warns(sweeping.SweepWarning, match="2 damaged parts"):
        again = sweep("paper-noisy", EPS, seeds=4, changes=SHORT, out=tmp_path / "x.nc")
    xr.testing.assert_equal(whole, again)


def test_the_parts_of_another_sweep_are_not_mixed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _unfinished(tmp_path, monkeypatch)
    with pytest.raises(ResultError, match="unfinished sweep with other seeds"):
        sweep("paper-noisy", EPS, seeds=5, changes=SHORT, out=tmp_path / "x.nc")
    with pytest.raises(ResultError, match="unfinished sweep with other scenario"):
        sweep("paper-noisy", EPS, seeds=4, changes={**SHORT, "plant.m": 1.1}, out=tmp_path / "x.nc")


def test_two_sweeps_do_not_write_one_file(tmp_path: Path) -> None:
    wanted = plan("paper-noisy", EPS, 2, None, SHORT)

    def meanwhile(done: int, runs: int) -> None:
        with pytest.raises(ResultError, match=f"is being computed by process {os.getpid()} on "):
            sweep_planned(wanted, tmp_path / "x.nc", on_threads(1))

    sweep_planned(wanted, tmp_path / "x.nc", on_threads(1), progress=meanwhile)


def test_a_result_of_another_sweep_is_not_overwritten(tmp_path: Path) -> None:
    sweep("paper-clean", EPS, changes=SHORT, out=tmp_path / "x.nc")
    before = (tmp_path / "x.nc").read_bytes()
    with pytest.raises(ResultError, match="result of something else"):
        sweep("paper-clean", EPS, 2, changes=SHORT, out=tmp_path / "x.nc")
    assert (tmp_path / "x.nc").read_bytes() == before


COMMAND = [
    *(sys.executable, "-m", "hillobs", "sweep", "paper-noisy", "--no-figures"),
    *("--over", "high_gain.eps_h=log:0.02:0.5:40"),
]


@pytest.mark.parametrize("kind", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
def test_a_killed_command_goes_on(kind: signal.Signals, tmp_path: Path) -> None:
    command = [*COMMAND, "--seeds", "64", "--set", "duration=4", "--out"]
    process = subprocess.Popen([*command, "cut.nc"], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    folder = tmp_path / "cut.nc.parts"
    while not list(folder.glob("*.part")) and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(kind)
    _, words = process.communicate()
    if process.returncode == 0:
        pytest.skip("it was done before the signal came")
    if kind is signal.SIGKILL:
        assert process.returncode == -kind
    else:
        assert process.returncode == 128 + kind
        assert words.startswith("hillobs: stopped; what is done is kept in cut.nc.parts")
    for name in ("cut.nc", "whole.nc"):
        subprocess.run([*command, name], cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "cut.nc").read_bytes() == (tmp_path / "whole.nc").read_bytes()


def test_a_very_large_sweep_must_be_meant() -> None:
    command = [*COMMAND, "--over", "plant.m=lin:1:1.2:10000", "--seeds", "1000"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "400,000,000 runs are more than 100,000,000; say --yes" in done.stderr


def test_numbers_reach_the_blocks_of_a_plan_as_they_reach_a_run() -> None:
    over = {"muscle.k": [19.0, 20.0], "muscle1.k": [18.0], "plant.m": [1.1]}
    wanted = plan("paper-clean", over, 1, None, SHORT)
    for run, k in enumerate((19.0, 20.0)):
        given = prepare("paper-clean", None, {**SHORT, "muscle.k": k, "muscle1.k": 18.0, "plant.m": 1.1})
        for block in given.loop.blocks:
            expected = given.table.values(block, given.scenario.given)
            np.testing.assert_array_equal(wanted.numbers(np.arange(2))[block.name][run], expected)


def test_the_quick_inverse_of_the_tendon_changes_nothing() -> None:
    """With and without it, in a scenario whose tendons go slack."""
    prepared = prepare("slack", None, {"duration": 10.0})
    values = {b.name: prepared.table.values(b, prepared.scenario.given) for b in prepared.loop.blocks}
    plain = dataclasses.replace(prepared.loop, bank=dataclasses.replace(prepared.loop.bank, near=None))
    one, other = (
        compile_loop(loop).run(prepared.grid, 0, values, prepared.observers) for loop in (prepared.loop, plain)
    )
    for name in prepared.observers:
        np.testing.assert_allclose(one[name].x, other[name].x, rtol=0, atol=1e-10)
