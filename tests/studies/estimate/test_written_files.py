"""What an estimate writes is read back as it was computed, is the same each time, and leaves nothing stale."""

import csv
import hashlib
import io
import itertools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from hillobs.studies.estimate.files import save_estimates
from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.scores import scores
from hillobs.studies.files.datasets.netcdf import load
from hillobs.studies.files.writing import write_whole
from hillobs.studies.laboratory.recording import Recording, read_recording
from places import DOCS, contents
from shipped_recording import ALL_OBSERVERS, MUSCLES, SHIPPED, write_measured

pytestmark = pytest.mark.numerics
ESTIMATED = ("position", "velocity", "disturbance", "tendon_length", "fibre_length", "fibre_velocity", "activation")


def test_what_is_written_is_read_back(noisy: xr.Dataset, command: Callable[..., tuple[int, str, str]]) -> None:
    before = hashlib.sha256(SHIPPED.read_bytes()).digest()
    arguments = ["estimate", str(SHIPPED), "--muscles", str(MUSCLES), "--no-figures", "--no-verdict"]
    code, out, err = command(*arguments, *itertools.chain(*(("--observer", name) for name in ALL_OBSERVERS)))
    assert (code, err) == (0, "")
    assert hashlib.sha256(SHIPPED.read_bytes()).digest() == before
    folder = Path("estimates")
    names = [
        "estimates.csv",
        "estimates.nc",
        "scores.csv",
        *(f"estimates-{name}.sto" for name in ALL_OBSERVERS),
    ]
    assert sorted(contents(folder)) == sorted(names)
    assert all(name in out for name in names)
    read = load(folder / "estimates.nc")
    xr.testing.assert_identical(read, noisy)
    plain = {f"{q}_{j}" for q in ESTIMATED[3:] for j in (1, 2)} | {"velocity", "disturbance"}
    for name in ALL_OBSERVERS:
        units = {q: noisy[f"{q.rstrip('_12')}_hat"].attrs["units"] for q in (*plain, "position")}
        labels = {q: f"{name}.{q}_hat" + (f" [{unit}]" if unit != "1" else "") for q, unit in units.items()}
        for recording in (
            read_recording(folder / "estimates.csv", labels),
            read_recording(folder / f"estimates-{name}.sto"),
        ):
            assert recording.time.tobytes() == noisy.time.values.tobytes()
            assert recording["position"].tobytes() == noisy.position_hat.sel(observer=name).values.tobytes()
            assert recording["force_1"].tobytes() == noisy.force.sel(muscle=1).values.tobytes()
            assert set(recording.true) == plain
            for quantity, values in recording.true.items():
                of = noisy[f"{quantity.rstrip('_12')}_hat"].sel(observer=name)
                of = of.sel(muscle=int(quantity[-1])) if quantity[-1] in "12" else of
                assert values.tobytes() == of.values.tobytes(), quantity
    rows = (folder / "scores.csv").read_text().splitlines()
    assert rows[0] == "observer,quantity,muscle,unit,rmse,peak"
    assert len(rows) == 1 + len(scores(noisy)) == 1 + len(ALL_OBSERVERS) * (3 + 4 * 3)
    assert "RMSE after 1 s" in out
    # the page shows what is printed
    page = [line.split() for line in (DOCS / "estimate.md").read_text().splitlines()]
    table = out.partition("RMSE after 1 s")[2].partition("written")[0]
    assert all(row in page for row in printed(table))


def printed(table: str) -> list[list[str]]:
    return [line.split() for line in table.splitlines() if line.strip()]


def test_the_same_recording_gives_the_same_files(
    short: Recording, command: Callable[..., tuple[int, str, str]]
) -> None:
    write_measured(short, Path("short.csv"))
    for folder in "ab":
        arguments = ("short.csv", "--muscles", str(MUSCLES), "--observer", "sliding_mode", "--out", folder)
        code, out, _ = command("estimate", *arguments)
        assert code == 0
    assert "RMSE" not in out
    both = [contents(Path(folder)) for folder in "ab"]
    assert both[0] == both[1]
    names = ("estimates-sheet.png", "estimates.csv", "estimates.nc", "estimates.sto")
    assert sorted(both[0]) == sorted(names)
    assert command("figures", "a/estimates.nc", "--out", "drawn")[0] == 0
    for name, drawn in contents(Path("drawn")).items():
        assert drawn == both[0][name]


def test_deviations_are_written_in_the_units_of_the_estimates(noisy: xr.Dataset, tmp_path: Path) -> None:
    both = noisy.sel(observer=["high_gain", "kalman"])
    save_estimates(both, [], tmp_path)
    with (tmp_path / "estimates.csv").open() as file:
        names, *rows = csv.reader(file)
    # an observer that knows no noise has the part of the numbers alone, and nothing else has an empty column
    assert not [name for name in names if name.startswith("high_gain") and "_sd [" in name]
    assert "high_gain.activation_1_sd_muscle" in names
    assert "kalman.velocity_sd_muscle [m/s]" not in names
    columns = dict(zip(names, np.array(rows, dtype=float).T, strict=True))
    of = both.sel(observer="kalman")
    np.testing.assert_array_equal(columns["kalman.velocity_sd [m/s]"], of.velocity_sd)
    np.testing.assert_array_equal(columns["kalman.fibre_length_2_sd [m]"], of.fibre_length_sd.sel(muscle=2))
    np.testing.assert_array_equal(columns["kalman.activation_1_sd_muscle"], of.activation_sd_muscle.sel(muscle=1))
    table = (tmp_path / "estimates-kalman.sto").read_text().partition("endheader\n")[2]
    label = "/forceset/m1/activation_sd"
    values = np.genfromtxt(io.StringIO(table), delimiter="\t", skip_header=1)
    place = table.splitlines()[0].split("\t").index(label)
    np.testing.assert_array_equal(values[:, place], of.activation_sd.sel(muscle=1))


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
    write_whole(tmp_path / "estimates-sheet.pdf", b"of the earlier run")
    estimates = estimate(short, MUSCLES, ["high_gain", "high_gain_3"])
    written = save_estimates(estimates, scores(estimates), tmp_path)
    names = {"estimates.nc", "estimates.csv", "estimates-high_gain.sto", "estimates-high_gain_3.sto"}
    assert {path.name for path in written} == names
    assert contents(tmp_path).keys() == {*names, *users, "estimates-folder.sto"}
    save_estimates(estimates.sel(observer=["high_gain"]), [], tmp_path)
    assert not (tmp_path / "estimates-high_gain.sto").exists()
    # scores that we have not written stay, and those that were changed since
    (tmp_path / "scores.csv").write_text("observer,points\n")
    save_estimates(estimates, [], tmp_path)
    assert contents(tmp_path).keys() == {*names, *users, "estimates-folder.sto", "scores.csv"}
