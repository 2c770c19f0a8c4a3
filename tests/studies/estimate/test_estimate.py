"""Estimates of recordings: as good as promised, the same in any unit, written as read; what is wrong is a sentence."""

import dataclasses
import hashlib
import itertools
import json
from collections.abc import Callable, Mapping
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import xarray as xr
from hypothesis import example, given, settings
from hypothesis import strategies as st

import hillobs
from double_pole import double_pole
from hillobs.codegen import filters
from hillobs.model.block import Symbols, symbols
from hillobs.observers import PAPER
from hillobs.studies.cli.reports.estimate import failures, notes, timing
from hillobs.studies.estimate import follow
from hillobs.studies.estimate.dataset import arguments as again
from hillobs.studies.estimate.files import save_estimates
from hillobs.studies.estimate.run import compile_observers, estimate
from hillobs.studies.estimate.scores import scores
from hillobs.studies.figures.estimate import estimate_sheet
from hillobs.studies.files.errors import RecordingError, ScenarioError
from hillobs.studies.files.netcdf import load, save_netcdf
from hillobs.studies.files.tables import Series, write_csv
from hillobs.studies.laboratory.muscles import MusclePair, read_muscles
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.laboratory.scales import Scales, scales
from places import DATA, DOCS, RECORDINGS

pytestmark = pytest.mark.numerics

SHIPPED, MUSCLES = RECORDINGS / "dgf_smooth_noisy.csv.gz", RECORDINGS / "dgf_smooth.toml"
ALL = ["high_gain", "high_gain_3", "sliding_mode", "adaptive_sliding_mode"]
ESTIMATED = ("position", "velocity", "disturbance", "tendon_length", "fibre_length", "fibre_velocity", "activation")


@pytest.fixture(scope="module")
def noisy() -> xr.Dataset:
    return estimate(SHIPPED, MUSCLES, ALL)


@pytest.fixture(scope="module")
def short() -> Recording:
    """The first 1.5 s of the shipped recording, without its truth."""
    return part(read_recording(SHIPPED), slice(0, 300))


def part(whole: Recording, which: object, **changes: object) -> Recording:
    cut = {name: getattr(whole, name)[which] for name in ("time", "position", "force_1", "force_2", "rows")}
    return dataclasses.replace(whole, **{**cut, "true": {}, **changes})


def rmse(dataset: xr.Dataset, quantity: str) -> dict[str, float]:
    return {s.observer: s.rmse for s in scores(dataset) if s.quantity == quantity and s.muscle in ("", "both")}


# how good


def test_the_noisy_recording_is_estimated_as_well_as_promised(noisy: xr.Dataset) -> None:
    bounds = {"high_gain": 0.02, "high_gain_3": 0.02, "sliding_mode": 0.025, "adaptive_sliding_mode": 0.03}
    found = rmse(noisy, "activation")
    assert all(found[name] < bound for name, bound in bounds.items()), found
    assert max(rmse(noisy, "velocity").values()) < 0.006
    assert max(rmse(noisy, "fibre_length").values()) < 2e-4
    assert not noisy.velocity_limited.any()
    assert not list(failures(noisy))


def test_the_correction_is_worth_it(noisy: xr.Dataset) -> None:
    plain = estimate(SHIPPED, MUSCLES, corrected=False)
    for quantity in ("velocity", "activation"):
        before, after = rmse(plain, quantity), rmse(noisy, quantity)
        # no layers to correct: two libraries differ by last bits, 1e−16, of which its gains make at most 1e3
        assert before["high_gain"] == pytest.approx(after["high_gain"], rel=1e-12)
        for name in ("sliding_mode", "adaptive_sliding_mode"):
            assert before[name] > 1.15 * after[name], (quantity, name)


@pytest.mark.parametrize(
    ("recording", "muscles"),
    [
        ("dgf_smooth_excerpt.csv", "dgf_smooth"),
        ("dgf_random_excerpt.sto", "dgf_random"),
        ("millard_steps_excerpt.csv.gz", "millard_steps"),
    ],
)
def test_activations_follow_from_the_true_columns(recording: str, muscles: str) -> None:
    """Curves, signs and units are OpenSim's: forces, lengths and velocities of a file give its activations."""
    read, pair = read_recording(DATA / recording), read_muscles(RECORDINGS / f"{muscles}.toml")
    s = scales(pair)
    for j, force, L_m in ((1, read.force_1, read.position), (2, read.force_2, pair.C - read.position)):
        a = activation(pair, s, j, force, L_m, read.true[f"fibre_velocity_{j}"])
        np.testing.assert_allclose(a, read.true[f"activation_{j}"], atol=1e-6)


def activation(
    pair: MusclePair, s: Scales, j: int, force: np.ndarray, L_m: np.ndarray, velocity: np.ndarray
) -> np.ndarray:
    """From a tendon force, a muscle's length and the velocity of its fibre, in SI."""
    curve = getattr(pair, f"muscle{j}").curves
    numbers = Symbols({name: ca.SX(s.numbers[f"muscle{j}.{name}"]) for name in curve.parameters})
    F, L, u = (ca.SX.sym(name) for name in "FLu")
    a = curve.activation(F, L - curve.Phi_S_inv(F, numbers), u, numbers)
    # u_j = −fibre velocity_j/(l₀v₀)
    return np.array(ca.Function("a", [F, L, u], [a])(s.forces(force), s.lengths(L_m), -velocity / s.length / s.rate))[
        :, 0
    ]


UNLIKE = """
mass = 12.0
C = 0.5
[muscle1]
curves = "degroote_fregly2016"
F_max = 1500.0
optimal_fibre_length = 0.08
tendon_slack_length = 0.16
v_max = 8.0
[muscle2]
curves = "thelen2003"
F_max = 900.0
optimal_fibre_length = 0.1
tendon_slack_length = 0.15
v_max = 10.0
damping = 0.1
"""


@pytest.fixture(scope="module")
def unlike(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A recording at 1 kHz without noise of two unlike muscles with two curve sets, by our own plant."""
    folder = tmp_path_factory.mktemp("unlike")
    (folder / "muscles.toml").write_text(UNLIKE)
    pair = read_muscles(folder / "muscles.toml")
    s = scales(pair)
    period = float(s.rate * 1e-3)
    changes = {f"muscle{j}.curves": getattr(pair, f"muscle{j}").curves.name for j in (1, 2)} | dict(s.numbers)
    changes |= {"initial.x1": 3.1, "initial.x3": 2.03, "initial.x4": 1.92, "uncertainty.offset": 0.02}
    changes |= {"uncertainty.amplitude": 0.08, "uncertainty.frequency": 0.3, "activation1.frequency": 0.35}
    changes |= {"activation2.frequency": 0.25, "noise.period": 0, "noise.drift": 0}
    changes |= {"duration": 3000 * period, "step": period / 2, "record": period}
    run = hillobs.simulate("activation", observers=["high_gain"], changes=changes)
    x, y = run.x, run.y.values
    write_csv(
        folder / "clean.csv",
        [
            Series("time", "s", run.time.values / s.rate),
            Series("position", "m", s.metres(y[:, 0])),
            *(Series(f"force_{j}", "N", y[:, j] * s.force) for j in (1, 2)),
            Series("velocity", "m/s", s.velocity(x.sel(state="x2").values)),
            Series("disturbance", "N", s.disturbance(run.Delta.values)),
            *(Series(f"tendon_length_{j}", "m", s.metres(x.sel(state=f"x{j + 2}").values)) for j in (1, 2)),
            *(Series(f"fibre_velocity_{j}", "m/s", s.fibre_velocity(run.u.sel(muscle=j).values)) for j in (1, 2)),
            *(Series(f"activation_{j}", "1", run.a.sel(muscle=j).values) for j in (1, 2)),
        ],
    )
    return folder / "clean.csv", folder / "muscles.toml"


def test_a_clean_recording_of_unlike_muscles_is_estimated_as_well_as_promised(unlike: tuple[Path, Path]) -> None:
    found = estimate(*unlike, ALL)
    assert np.ptp(found.true_activation.values) > 0.15
    assert np.ptp(found.true_velocity.values) > 0.08
    assert max(rmse(found, "activation").values()) < 0.003, rmse(found, "activation")
    velocity = rmse(found, "velocity")
    assert velocity["high_gain"] < 5e-5
    assert velocity["sliding_mode"] < 1.5e-3
    assert velocity["adaptive_sliding_mode"] < 3e-3
    assert max(rmse(found, "tendon_length").values()) < 2e-5
    # û of order 3 has no lag of first order
    assert rmse(found, "activation")["high_gain_3"] < rmse(found, "activation")["high_gain"] / 5
    assert not found.activation_limited.isel(time=slice(1000, None)).any()


# what does not matter


@settings(max_examples=10)
@given(
    st.floats(1e-2, 1e3), st.floats(0.05, 5), st.floats(0.2, 5), st.sampled_from(["high_gain", "adaptive_sliding_mode"])
)
@example(7.3, 0.31, 1.7, "sliding_mode")
def test_units_and_sizes_change_no_activation(
    short: Recording, force: float, length: float, rate: float, observer: str
) -> None:
    pair = read_muscles(MUSCLES)
    muscle = dataclasses.replace(
        pair.muscle1,
        F_max=pair.muscle1.F_max * force,
        optimal_fibre_length=pair.muscle1.optimal_fibre_length * length,
        tendon_slack_length=pair.muscle1.tendon_slack_length * length,
        v_max=pair.muscle1.v_max * rate,
    )
    # m = mass l₀ v_max²/F_max
    mass = pair.mass * force / (length * rate**2)
    other = MusclePair(mass, pair.C * length, muscle, muscle)
    scaled = dataclasses.replace(
        short,
        time=short.time / rate,
        position=short.position * length,
        force_1=short.force_1 * force,
        force_2=short.force_2 * force,
    )
    before, after = estimate(short, pair, observer), estimate(scaled, other, observer)
    np.testing.assert_allclose(after.activation_hat, before.activation_hat, atol=1e-9)
    np.testing.assert_allclose(after.velocity_hat, before.velocity_hat * length * rate, atol=1e-9 * length * rate)
    np.testing.assert_allclose(after.disturbance_hat, before.disturbance_hat * force, atol=1e-6 * force)


def test_the_mirror_image_has_its_muscles_swapped(short: Recording) -> None:
    pair = read_muscles(MUSCLES)
    mirrored = dataclasses.replace(
        short, position=pair.C - short.position, force_1=short.force_2, force_2=short.force_1
    )
    before, after = estimate(short, pair, ALL), estimate(mirrored, pair, ALL)
    # the adaptive laws jump; what is left of a rounding error is larger there
    np.testing.assert_allclose(after.activation_hat[..., ::-1], before.activation_hat, atol=1e-6)
    np.testing.assert_allclose(after.velocity_hat, -before.velocity_hat, atol=1e-7)


def test_when_it_began_does_not_matter(short: Recording) -> None:
    later = dataclasses.replace(short, time=short.time + 1024.0)
    before, after = (estimate(one, MUSCLES, "high_gain") for one in (short, later))
    np.testing.assert_allclose(after.activation_hat, before.activation_hat, atol=1e-8)
    assert after.time[0] == 1024


def test_observers_do_not_see_each_other_nor_how_much_is_kept(noisy: xr.Dataset) -> None:
    alone = estimate(SHIPPED, MUSCLES, "sliding_mode", keep_every=7)
    for name in alone.data_vars:
        whole = noisy[name].sel(observer=["sliding_mode"]) if "observer" in noisy[name].dims else noisy[name]
        xr.testing.assert_identical(alone[name], whole.isel(time=slice(None, None, 7), missing_dims="ignore"))
    assert alone.sizes["time"] == 286
    assert "estimates are kept of every 7th sample" in list(notes(alone))


@pytest.mark.parametrize("chunk", [1, 37, 299, 300])
def test_pieces_change_no_bit(short: Recording, chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    uneven = part(short, np.flatnonzero(np.arange(300) % 7 < 5))
    told: list[float] = []
    whole = estimate(uneven, MUSCLES, "sliding_mode", keep_every=3)
    monkeypatch.setattr(follow, "_CHUNK", chunk)
    xr.testing.assert_identical(estimate(uneven, MUSCLES, "sliding_mode", keep_every=3, progress=told.append), whole)
    assert told == sorted(told)
    assert told[-1] == 1


def test_progress_rises_to_1_over_reading_and_all_observers(short: Recording) -> None:
    told: list[float] = []
    estimate(short, MUSCLES, progress=told.append)
    assert told == sorted(told)
    assert (told[0] > 0, told[-1], len(told)) == (True, 1, 3)
    told.clear()
    estimate(SHIPPED, MUSCLES, progress=told.append)
    assert told == sorted(told)
    # the file is the first of four parts
    assert (told[0] <= 0.25, 0.25 in told, told[-1]) == (True, True, 1)


def test_samples_may_come_unevenly(noisy: xr.Dataset) -> None:
    """Two of seven missing, steps of 5, 10 and 15 ms: stable, and hardly worse."""
    whole = read_recording(SHIPPED)
    which = np.flatnonzero(~np.isin(np.arange(len(whole)) % 14, (2, 5, 6, 10)))
    found = estimate(part(whole, which, true={k: v[which] for k, v in whole.true.items()}), MUSCLES, ALL)
    for name, error in rmse(found, "activation").items():
        assert error < 1.3 * rmse(noisy, "activation")[name], name
    assert "some after 15 ms" in next(notes(found))


# files


def test_what_is_written_is_read_back(noisy: xr.Dataset, command: Callable[..., tuple[int, str, str]]) -> None:
    before = hashlib.sha256(SHIPPED.read_bytes()).digest()
    arguments = ["estimate", str(SHIPPED), "--muscles", str(MUSCLES), "--no-figures"]
    code, out, err = command(*arguments, *itertools.chain(*(("--observer", name) for name in ALL)))
    assert (code, err) == (0, "")
    assert hashlib.sha256(SHIPPED.read_bytes()).digest() == before
    folder = Path("estimates")
    names = [
        "estimates.csv",
        "estimates.nc",
        "scores.csv",
        *(f"estimates-{name}.sto" for name in ALL),
    ]
    assert sorted(path.name for path in folder.iterdir()) == sorted(names)
    assert all(name in out for name in names)
    read = load(folder / "estimates.nc")
    xr.testing.assert_identical(read, noisy)
    plain = {f"{q}_{j}" for q in ESTIMATED[3:] for j in (1, 2)} | {"velocity", "disturbance"}
    for name in ALL:
        units = {q: noisy[f"{q.rstrip('_12')}_hat"].attrs["units"] for q in (*plain, "position")}
        labels = {q: f"{name}.{q}_hat" + (f" [{unit}]" if unit != "1" else "") for q, unit in units.items()}
        for found in (
            read_recording(folder / "estimates.csv", labels),
            read_recording(folder / f"estimates-{name}.sto"),
        ):
            assert found.time.tobytes() == noisy.time.values.tobytes()
            assert found.position.tobytes() == noisy.position_hat.sel(observer=name).values.tobytes()
            assert found.force_1.tobytes() == noisy.force.sel(muscle=1).values.tobytes()
            assert set(found.true) == plain
            for quantity, values in found.true.items():
                of = noisy[f"{quantity.rstrip('_12')}_hat"].sel(observer=name)
                of = of.sel(muscle=int(quantity[-1])) if quantity[-1] in "12" else of
                assert values.tobytes() == of.values.tobytes(), quantity
    rows = (folder / "scores.csv").read_text().splitlines()
    assert rows[0] == "observer,quantity,muscle,unit,rmse,peak"
    assert len(rows) == 1 + len(scores(noisy)) == 1 + 4 * (3 + 4 * 3)
    assert "RMSE after 1 s" in out
    # nothing that is read is written over
    code, _, err = command("estimate", str(folder / "estimates.csv"), "--muscles", str(MUSCLES))
    assert (code, err.count("\n")) == (2, 1)
    assert "might be overwritten by its estimates; choose another folder with --out" in err
    # the page shows what is printed
    page = [line.split() for line in (DOCS / "estimate.md").read_text().splitlines()]
    table = out.partition("RMSE after 1 s")[2].partition("written")[0]
    assert all(row in page for row in printed(table))


def printed(table: str) -> list[list[str]]:
    return [line.split() for line in table.splitlines() if line.strip()]


def test_the_same_recording_gives_the_same_files(
    short: Recording, command: Callable[..., tuple[int, str, str]]
) -> None:
    inputs = ("position", "force_1", "force_2")
    write_csv(Path("short.csv"), [Series(n, "1", getattr(short, n)) for n in ("time", *inputs)])
    for folder in "ab":
        arguments = ("short.csv", "--muscles", str(MUSCLES), "--observer", "sliding_mode", "--out", folder)
        code, out, _ = command("estimate", *arguments)
        assert code == 0
    assert "RMSE" not in out
    contents = [{path.name: path.read_bytes() for path in Path(folder).iterdir()} for folder in "ab"]
    assert contents[0] == contents[1]
    names = ("estimates-sheet.pdf", "estimates-sheet.png", "estimates.csv", "estimates.nc", "estimates.sto")
    assert sorted(contents[0]) == sorted(names)
    assert command("figures", "a/estimates.nc", "--out", "drawn")[0] == 0
    for path in Path("drawn").iterdir():
        assert path.read_bytes() == contents[0][path.name]


def test_the_sheet_shows_errors_where_the_truth_is_known(noisy: xr.Dataset) -> None:
    labels = [axes.get_ylabel() for axes in estimate_sheet(noisy).axes]
    errors = [label for label in labels if label.startswith("error of")]
    assert errors == ["error of\nactivation 1", "error of\nactivation 2"]
    alone = noisy.drop_vars([name for name in noisy if str(name).startswith("true_")])
    assert len(estimate_sheet(alone).axes) == len(labels) - len(errors)
    bridged = alone.isel(time=[0]).assign(bridged=alone.bridged.isel(time=[0]) + 1)
    assert all(axes.collections for axes in estimate_sheet(bridged).axes)


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"observers": "high_gain_3", "corrected": False, "keep_every": 3},
        {"changes": {"high_gain.eps_h": 1 / 3, "sliding_mode.tau_c": 0.2}, "mapping": {"position": "position"}},
    ],
)
def test_a_result_is_repeated_from_its_own_file(arguments: dict[str, object], tmp_path: Path) -> None:
    once = estimate(SHIPPED, MUSCLES, **arguments)
    save_netcdf(once, tmp_path / "x.nc")
    xr.testing.assert_identical(estimate(SHIPPED, **again(load(tmp_path / "x.nc"))), once)


@pytest.mark.parametrize("first", ["tables.csv", "thelen2003"])
def test_the_curves_of_unlike_muscles_are_in_the_file_too(
    first: str, unlike: tuple[Path, Path], tmp_path: Path
) -> None:
    (tmp_path / "tables.csv").write_bytes((DATA / "curves_millard_tables.csv").read_bytes())
    muscles = tmp_path / "muscles.toml"
    muscles.write_text(UNLIKE.replace("degroote_fregly2016", first))
    once = estimate(unlike[0], muscles, "sliding_mode")
    save_netcdf(once, tmp_path / "x.nc")
    for path in (tmp_path / "tables.csv", muscles):
        path.unlink()
    xr.testing.assert_identical(estimate(unlike[0], **again(load(tmp_path / "x.nc"))), once)


def test_the_muscles_of_a_result_are_told_in_SI(noisy: xr.Dataset) -> None:
    muscles = json.loads(str(noisy.muscle_file.values))
    assert (muscles["mass"], muscles["C"]) == (20.0, 0.62)
    assert muscles["muscle2"] == {
        "curves": "degroote_fregly2016",
        "F_max": 1000.0,
        "optimal_fibre_length": 0.1,
        "tendon_slack_length": 0.2,
        "v_max": 10.0,
        **read_muscles(MUSCLES).muscle2.numbers,
    }


def test_what_an_earlier_run_has_left_does_not_pass_for_the_new_result(
    noisy: xr.Dataset, short: Recording, tmp_path: Path
) -> None:
    users = {
        "estimates-mine.sto": "estimates of mine\n",
        "estimates-yours.sto": "estimates of mine from elsewhere\n",
        "estimates.mot": "estimates of high_gain from elsewhere\n",
        "notes.txt": "",
    }
    for name, text in users.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "estimates-folder.sto").mkdir()
    save_estimates(noisy, scores(noisy), tmp_path)
    assert (tmp_path / "scores.csv").exists()
    assert (tmp_path / "estimates-sliding_mode.sto").exists()
    found = estimate(short, MUSCLES, ["high_gain", "high_gain_3"])
    written = save_estimates(found, scores(found), tmp_path)
    names = {"estimates.nc", "estimates.csv", "estimates-high_gain.sto", "estimates-high_gain_3.sto"}
    assert {path.name for path in written} == names
    assert {path.name for path in tmp_path.iterdir()} == {*names, *users, "estimates-folder.sto"}
    save_estimates(found.sel(observer=["high_gain"]), [], tmp_path)
    assert not (tmp_path / "estimates-high_gain.sto").exists()
    # scores that we have not written stay
    (tmp_path / "scores.csv").write_text("observer,points\n")
    save_estimates(found, [], tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {*names, *users, "estimates-folder.sto", "scores.csv"}


@pytest.mark.parametrize(
    ("seconds", "sentence"),
    [
        ((0.052, 9.04, 0.0312), "read in 0.05 s, observers built in 9.04 s, followed in 0.03 s: 16 µs a sample"),
        ((12.3, 36.2, 1712.0), "read in 12 s, observers built in 36 s, followed in 1,712 s: 855,572 µs a sample"),
        ((0.0, 0.0, 0.0), "read in 0.00 s, observers built in 0.00 s, followed in 0.00 s: 0.0 µs a sample"),
    ],
)
def test_times_are_told_without_powers_of_ten(
    seconds: tuple[float, float, float], sentence: str, noisy: xr.Dataset
) -> None:
    assert timing(noisy, *seconds) == sentence


def test_observers_are_built_before_they_are_needed(short: Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    compile_observers(read_muscles(MUSCLES), "high_gain")
    monkeypatch.setattr(filters, "load", lambda *arguments: pytest.fail("compiled"))
    estimate(short, MUSCLES, "high_gain")


# an observer of one's own


def test_a_users_own_observer_follows_a_recording(short: Recording) -> None:
    mine = double_pole("mine")
    # as fast as this both take one step from sample to sample, 0.05 in τ
    by_hand = {"mine.rate": 10, "high_gain.eps_h": 0.1, "high_gain.eps_L": 0.1}
    found = estimate(short, MUSCLES, ["high_gain", mine], changes=by_hand)
    assert json.loads(found.attrs["substeps"]) == {"high_gain": 1, "mine": 1}
    for name in ("position", "velocity", "fibre_length", "fibre_velocity", "activation"):
        ours, own = (found[f"{name}_hat"].sel(observer=observer).values for observer in ("high_gain", "mine"))
        np.testing.assert_allclose(own, ours, rtol=1e-9, atol=1e-10)
    assert next(line for line in notes(found) if line.startswith("mine")).endswith("sample; rate = 10")


def test_a_users_own_observer_has_its_defaults_and_steps_of_its_eigenvalues(short: Recording) -> None:
    mine = double_pole("mine")
    found = estimate(short, MUSCLES, mine)
    assert json.loads(found.attrs["gains"]) == {"mine": {}}
    assert "mine: 1 step from sample to sample" in list(notes(found))
    # its triple pole, 0.05 · rate/2.5
    fast = estimate(short, MUSCLES, mine, changes={"mine.rate": 200.0})
    assert json.loads(fast.attrs["substeps"]) == {"mine": 5}
    with pytest.raises(
        ScenarioError, match=r"the gains of mine are too fast for samples 0.05 apart: they ask for 1e\+"
    ):
        estimate(short, MUSCLES, mine, changes={"mine.rate": 5e7})


def test_an_observer_that_estimates_activations_itself_has_no_limits(short: Recording) -> None:
    plain = double_pole("mine")
    a = Symbols(a1_hat=ca.SX(0.25), a2_hat=ca.SX(0.5))
    found = estimate(short, MUSCLES, dataclasses.replace(plain, y=Symbols({**plain.y, **a})))
    assert (found.activation_hat == [0.25, 0.5]).all()
    assert not found.activation_limited.any()


@pytest.mark.parametrize("name", ["high_gain", "plant", "initial", "muscle1", "lengths", "tendons"])
def test_a_name_that_is_taken_is_refused(name: str, short: Recording) -> None:
    with pytest.raises(ScenarioError, match=f"the name '{name}' is taken; give your observer another one"):
        estimate(short, MUSCLES, double_pole(name))


def test_a_users_own_observer_that_no_recording_can_move_is_refused(short: Recording) -> None:
    mine = double_pole("mine")
    counting = symbols("n")
    counter = dataclasses.replace(mine, x=Symbols({**mine.x, **counting}), per_step=Symbols(n=counting.n + 1))
    with pytest.raises(ScenarioError, match="mine moves at the points of a time grid, and a recording has none"):
        estimate(short, MUSCLES, counter)
    with pytest.raises(ScenarioError, match="two observers are called 'mine'; give one another name"):
        estimate(short, MUSCLES, [mine, double_pole("mine")])
    assert estimate(short, MUSCLES, [mine, mine]).sizes["observer"] == 1


# what a recording lacks


def test_short_gaps_are_bridged_and_told(short: Recording) -> None:
    force = short.force_1.copy()
    force[100:110] = np.nan
    found = estimate(dataclasses.replace(short, force_1=force), MUSCLES, ALL)
    assert np.flatnonzero(found.bridged).tolist() == list(range(100, 110))
    np.testing.assert_allclose(found.force[100:110, 0], np.interp(np.arange(10), [-1, 10], short.force_1[[99, 110]]))
    told = list(notes(found))
    assert "gaps bridged by straight lines from 0.5 to 0.545 s" in told
    assert "force_1 has no value in 10 of 300 rows: 102–111" in told
    # the bridge is what a straight line would have been
    straight = dataclasses.replace(short, force_1=found.force[:, 0].values)
    np.testing.assert_array_equal(estimate(straight, MUSCLES, ALL).activation_hat, found.activation_hat)


@pytest.mark.parametrize(
    ("name", "places", "sentence"),
    [
        ("position", slice(50, 90), "position has no value in rows 52 to 91, 0.205 s; gaps of up to 0.1 s are bridged"),
        ("force_2", slice(0, 2), "force_2 has no value in row 2, an end of the recording"),
        ("force_1", slice(298, 300), "force_1 has no value in row 301, an end of the recording"),
        ("position", slice(None), "position has no value in row 2, an end of the recording"),
    ],
)
def test_gaps_that_nobody_can_bridge_are_refused(name: str, places: slice, sentence: str, short: Recording) -> None:
    values = getattr(short, name).copy()
    values[places] = np.nan
    assert refusal(dataclasses.replace(short, **{name: values})) == sentence


def refusal(recording: Recording, muscles: str | Path | MusclePair = MUSCLES) -> str:
    with pytest.raises(RecordingError) as caught:
        estimate(recording, muscles, "high_gain")
    return str(caught.value).removeprefix(f"{recording.source}: ")


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("force_1", -200.0, "row 12: force_1 = -200 N; a tendon only pulls, so forces are positive"),
        ("force_2", 2e4, "row 12: force_2 = 20000 N; F_max is 1000 N; is it in another unit?"),
        ("position", 310.0, "row 12: position = 310 m; the mass is between 0 and C = 0.62 m; is it in another unit?"),
        ("position", -0.1, "row 12: position = -0.1 m; the mass is between 0 and C = 0.62 m"),
    ],
)
def test_what_no_muscle_can_do_is_refused(name: str, value: float, sentence: str, short: Recording) -> None:
    values = getattr(short, name).copy()
    values[10:] = value
    assert refusal(dataclasses.replace(short, **{name: values})) == sentence


def test_missing_rows_and_slow_sampling_are_refused(short: Recording) -> None:
    rows = np.r_[0:100, 130:300]
    sentence = "there is no sample between rows 101 and 132, 0.155 s; gaps of up to 0.1 s are bridged"
    assert refusal(part(short, rows)) == sentence
    slow = dataclasses.replace(short, time=short.time * 20)
    assert (
        refusal(slow)
        == "a sample every 0.1 s is too few for muscles of v_max = 10/s; at most 0.07 s; is time in another unit?"
    )
    # slower muscles, rarer samples
    pair = read_muscles(MUSCLES)
    muscle = dataclasses.replace(pair.muscle1, v_max=0.5)
    found = estimate(slow, dataclasses.replace(pair, muscle1=muscle, muscle2=muscle, mass=8000.0), ALL)
    assert np.isfinite(found.activation_hat).all()


def test_one_row_is_too_few_and_two_will_do(short: Recording) -> None:
    assert refusal(part(short, slice(0, 1))) == "has one row of numbers; observers need two or more"
    for n in (2, 3, 49, 50, 51):
        found = estimate(part(short, slice(0, n)), MUSCLES, ALL)
        assert found.sizes == {"observer": 4, "time": n, "muscle": 2}
        assert np.isfinite(found.activation_hat).all()
        assert not scores(found)
        assert len(list(notes(found))) >= 5


def test_slack_and_limits_are_told(short: Recording) -> None:
    force = short.force_2.copy()
    force[120:160] = -0.5
    found = estimate(dataclasses.replace(short, force_2=force), MUSCLES, "high_gain")
    assert np.flatnonzero(found.slack.sel(muscle=2)).tolist() == list(range(120, 160))
    assert not found.slack.sel(muscle=1).any()
    told = "\n".join(notes(found))
    assert "tendon 2 carries no force from 0.6 to 0.795 s" in told
    assert "activation 2 would be below 0 or above 1" in told
    assert ((found.activation_hat >= 0) & (found.activation_hat <= 1)).all()


@pytest.mark.parametrize("mirrored", [False, True])
def test_muscles_that_are_swapped_are_suspected(noisy: xr.Dataset, mirrored: bool) -> None:
    told = "accelerates against the difference of the tendon forces"
    assert told not in "\n".join(notes(noisy))
    whole = read_recording(SHIPPED)
    wrong = {"position": 0.62 - whole.position} if mirrored else {"force_1": whole.force_2, "force_2": whole.force_1}
    assert told in "\n".join(notes(estimate(part(whole, slice(None), **wrong), MUSCLES, "high_gain")))


# by hand


def test_gains_by_hand_come_before_the_rule(noisy: xr.Dataset, short: Recording) -> None:
    found = estimate(short, MUSCLES, ["high_gain", "sliding_mode"], changes={"high_gain.eps_h": 0.3})
    gains = json.loads(found.attrs["gains"])
    rule = json.loads(estimate(short, MUSCLES).attrs["gains"])
    assert gains["high_gain"] == {**rule["high_gain"], "high_gain.eps_h": 0.3}
    assert gains["sliding_mode"] == rule["sliding_mode"]
    same = estimate(short, MUSCLES, "high_gain", changes=rule["high_gain"])
    np.testing.assert_array_equal(same.activation_hat[0], estimate(short, MUSCLES).activation_hat[0])


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"high_gain.eps": 0.1}, "unknown path 'high_gain.eps'; the nearest are high_gain.eps_h"),
        ({"eps_h": 0.1}, "'eps_h' is no gain of high_gain, sliding_mode, adaptive_sliding_mode; the muscle file"),
        ({"plant.m": 1.0}, "'plant.m' is no gain of"),
        ({"high_gain_3.eps_h": 1.0}, "'high_gain_3.eps_h' is no gain of"),
        ({"high_gain.eps_h": 0.0}, "high_gain.eps_h must be above 0, not 0"),
        ({"high_gain.eps_h": float("nan")}, "high_gain.eps_h must be a finite number, not nan"),
        ({"high_gain.eps_h": float("inf")}, "high_gain.eps_h must be a finite number, not inf"),
        (
            {"high_gain.eps_h": 1e-300},
            "the gains of high_gain are too fast for samples 0.05 apart: they ask for 6.67e+",
        ),
        ({"sliding_mode.delta_L": 0.0}, "sliding_mode.delta_L = 0 has no fastest rate"),
    ],
)
def test_wrong_gains_are_sentences(changes: Mapping[str, float], sentence: str, short: Recording) -> None:
    with pytest.raises(ScenarioError) as caught:
        estimate(short, MUSCLES, changes=changes)
    assert str(caught.value).startswith(sentence)
    assert len(str(caught.value)) < 300


def test_what_cannot_be_is_a_sentence(short: Recording) -> None:
    with pytest.raises(ScenarioError, match=r"unknown observer 'kalman'; there are high_gain, sliding_mode, adaptive"):
        estimate(short, MUSCLES, ["high_gain", "kalman"])
    with pytest.raises(ScenarioError, match="keep_every must be at least 1, not 0"):
        estimate(short, MUSCLES, keep_every=0)
    many = dataclasses.replace(short, time=np.broadcast_to(0.0, 10**7))
    with pytest.raises(ScenarioError, match=r"10,000,000 samples make .* keep every 6th \(--every 6\) or fewer"):
        estimate(many, MUSCLES)
    assert estimate(short, MUSCLES).observer.values.tolist() == list(PAPER)
    assert estimate(short, MUSCLES, ["high_gain", "high_gain"]).sizes["observer"] == 1


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        ((), 2, "Missing option '--muscles'."),
        (("--muscles", "nowhere.toml"), 2, "nowhere.toml: cannot be read: No such file or directory"),
        (("--muscles", "short.csv"), 2, "short.csv: not valid TOML"),
        (("--muscles", str(MUSCLES), "--observer", "kalman"), 2, "unknown observer 'kalman'"),
        (("--muscles", str(MUSCLES), "--every", "1.5"), 2, "--every must be a whole number of at least 1, not '1.5'"),
        (("--muscles", str(MUSCLES), "--set", "high_gain.eps_h=fast"), 2, "high_gain.eps_h must be a number"),
        (("--muscles", str(MUSCLES), "--map", "position=x"), 2, "short.csv: position is mapped to 'x', which is not"),
        (
            ("--muscles", str(MUSCLES), "--map", "position=force_1"),
            2,
            "short.csv: column 'force_1 [N]': N is the unit of a force",
        ),
        (("--muscles", str(MUSCLES), "--map", "position=position[mm]"), 2, "short.csv: column 'position [m]'"),
        (("--muscles", str(MUSCLES), "--out", "short.csv"), 2, "short.csv cannot be written to: it is not a folder"),
        # unstable whatever the step
        (("--muscles", str(MUSCLES), "--set", "high_gain.h11=-300"), 1, "high_gain: its numbers end at 0.045 s"),
        (("--muscles", str(MUSCLES), "--set", "high_gain.h12=-1e9"), 2, "the gains of high_gain are too fast"),
    ],
)
def test_mistakes_on_the_command_line_are_one_sentence(
    arguments: tuple[str, ...], code: int, sentence: str, short: Recording, command: Callable[..., tuple[int, str, str]]
) -> None:
    inputs = {"time": "s", "position": "m", "force_1": "N", "force_2": "N"}
    write_csv(Path("short.csv"), [Series(name, unit, getattr(short, name)) for name, unit in inputs.items()])
    found, _, err = command("estimate", "short.csv", "--no-figures", *arguments)
    assert found == code
    assert err.startswith(f"hillobs: {sentence}")
    assert err.count("\n") == 1
    # what failed is written all the same, and nothing else is
    assert Path("estimates", "estimates.nc").exists() == (code == 1)


numbers = st.floats(allow_nan=False, allow_infinity=False, width=64)


@settings(max_examples=60)
@given(
    st.lists(
        st.tuples(
            st.one_of(st.just(0.005), st.floats(1e-9, 0.2)),
            st.one_of(st.floats(0, 0.62), st.just(float("nan")), numbers),
            st.one_of(st.floats(0, 2000), st.floats(-200, 1e4), st.just(float("nan")), numbers),
            st.floats(-150, 10_000),
        ),
        min_size=1,
        max_size=60,
    )
)
def test_whatever_was_recorded_there_is_a_result_or_one_sentence(
    rows: list[tuple[float, float, float, float]],
) -> None:
    steps, position, force_1, force_2 = np.array(rows).T
    recording = Recording("any.csv", np.cumsum(steps), position, force_1, force_2, {}, np.arange(len(rows)) + 2)
    told = ""
    try:
        found = estimate(recording, MUSCLES, ALL)
        assert len(list(notes(found))) >= 5
        a = found.activation_hat.values
        assert (np.isnan(a) | ((a >= 0) & (a <= 1))).all()
        assert np.isnan(a).any() <= bool(list(failures(found)))
    except RecordingError as error:
        told = str(error)
    assert not told or told.startswith("any.csv: ")
    assert "\n" not in told
