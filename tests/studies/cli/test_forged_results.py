"""Anyone can seal a file: whatever is in it, a reader gets what it relies on, or a sentence."""

import json
import random
import tracemalloc
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr

from forgeries import TABLES, mutations, retabled, with_table
from hillobs import Error, ResultError, arguments, estimate, load, simulate
from hillobs.studies.cli.reports import sweep as report
from hillobs.studies.estimate.schema import check_estimates
from hillobs.studies.files.datasets.netcdf import save_netcdf, sealed, unsealed
from hillobs.studies.simulate.schema import check_run
from hillobs.studies.sweep.schema import check_sweep
from places import RECORDINGS

# of some thousands; the report of a sweep takes longest
_SOME = {"run": 150, "sweep": 25, "estimates": 150}


@pytest.fixture(scope="module")
def results(line: xr.Dataset) -> dict[str, tuple[xr.Dataset, Callable[[xr.Dataset], object]]]:
    """A good result of each kind, and what reads it."""
    short = {"duration": 0.2, "score.start": 0.1}
    estimates = estimate(RECORDINGS / "dgf_smooth_noisy.csv.gz", RECORDINGS / "dgf_smooth.toml")

    def reported(dataset: xr.Dataset) -> None:
        check_sweep(dataset)
        assert list(report.notes(dataset))
        report.tables(dataset)

    def repeated(dataset: xr.Dataset) -> None:
        check_estimates(dataset)
        arguments(dataset)

    return {
        "run": (simulate("paper-clean", changes=short), check_run),
        "sweep": (line, reported),
        "estimates": (estimates.isel(time=slice(0, 50)), repeated),
    }


@pytest.mark.parametrize("kind", ["run", "sweep", "estimates"])
def test_a_good_result_passes(kind: str, results, tmp_path: Path) -> None:
    good, read = results[kind]
    read(good)
    save_netcdf(good, tmp_path / "x.nc")
    read(load(tmp_path / "x.nc"))


@pytest.mark.parametrize("kind", ["run", "sweep", "estimates"])
def test_a_changed_result_is_read_or_refused_in_a_sentence(kind: str, results) -> None:
    good, read = results[kind]
    refused = 0
    for what, change in random.Random(1).sample(list(mutations(good)), _SOME[kind]):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # xarray's on odd values
                changed = change(good)
        except ValueError:
            continue
        try:
            read(changed)
        except Error as error:
            refused += 1
            sentence = str(error)
        except Exception as error:
            pytest.fail(f"{what}: {type(error).__name__}: {error}")
        else:
            continue
        assert sentence.isprintable(), what
    assert refused


@pytest.fixture(scope="module")
def sealed_run(results, tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("run") / "x.nc"
    save_netcdf(results["run"][0], path)
    return path.read_bytes()


@pytest.mark.parametrize("change", TABLES.values(), ids=TABLES)
def test_a_table_of_contents_that_makes_no_sense_is_refused(change, sealed_run: bytes, tmp_path: Path) -> None:
    path = tmp_path / "x.nc"
    path.write_bytes(retabled(sealed_run, change))
    with pytest.raises(ResultError, match=r"x\.nc cannot be read: it is no result of hillobs: ") as refused:
        load(path)
    assert str(refused.value).isprintable()


@pytest.mark.parametrize("table", [b"", b"{}", b"[" * 100_000, b"\xff", b"null", b"9" * 100_000])
def test_a_table_of_contents_that_is_none_is_refused(table: bytes, sealed_run: bytes, tmp_path: Path) -> None:
    (tmp_path / "x.nc").write_bytes(with_table(sealed_run[:5_000], table))
    with pytest.raises(ResultError, match=r"x\.nc cannot be read: it is no result of hillobs: "):
        load(tmp_path / "x.nc")


def test_the_parser_of_hdf5_never_sees_a_file_of_others(sealed_run: bytes, tmp_path: Path) -> None:
    """A result is read as it was where only what HDF5 reads has been damaged."""
    (tmp_path / "good.nc").write_bytes(sealed_run)
    for superblock in (b"\0" * 48, b"\xff" * 48):
        (tmp_path / "x.nc").write_bytes(sealed(superblock + unsealed(sealed_run)[48:]))
        xr.testing.assert_identical(load(tmp_path / "x.nc"), load(tmp_path / "good.nc"))


def test_no_more_is_inflated_than_a_chunk_holds(tmp_path: Path) -> None:
    """A hundred megabytes of zeros, deflated to a tenth of one; beside that a table and a Dataset are small."""
    zeros = zlib.compress(b"\0" * 10**8)
    entry = {"dimensions": ["time"], "type": "|i1", "shape": [8], "chunk": [8], "attributes": {}}
    table = {"coordinates": [], "attributes": {}, "variables": {"bomb": {**entry, "pieces": [[0, len(zeros), 1]]}}}
    (tmp_path / "x.nc").write_bytes(with_table(zeros, json.dumps(table).encode()))
    tracemalloc.start()
    try:
        assert load(tmp_path / "x.nc").bomb.values.tolist() == [0] * 8
        assert tracemalloc.get_traced_memory()[1] < 10**7
    finally:
        tracemalloc.stop()


def test_figures_of_what_is_no_whole_result_are_refused(command, results, tmp_path: Path) -> None:
    save_netcdf(results["run"][0].drop_vars("taut"), tmp_path / "x.nc")
    code, out, err = command("figures", "x.nc")
    assert (code, out, err) == (2, "", "hillobs: x.nc cannot be drawn: it has no taut\n")


def test_a_sweep_does_not_go_on_with_a_forged_result(command, tmp_path: Path) -> None:
    call = ("sweep", "paper-clean", "--over", "high_gain.eps_h=0.1,0.2", "--set", "duration=0.2", "--no-figures")
    call += ("--set", "score.start=0.1", "--out", "x.nc")
    assert command(*call)[0] == 0
    forged = load(tmp_path / "x.nc").drop_vars("failed_at")
    (tmp_path / "x.nc").unlink()
    save_netcdf(forged, tmp_path / "x.nc")
    code, out, err = command(*call)
    assert (code, out) == (2, "")
    assert err == "hillobs: x.nc is there already, and cannot be used: it has no failed_at\n"


def test_the_muscles_in_a_result_name_no_file(results) -> None:
    estimates = results["estimates"][0].copy()
    estimates["muscle_file"] = xr.DataArray(str(estimates.muscle_file.values).replace("degroote_fregly2016", "my.csv"))
    with pytest.raises(Error, match=r"muscle1\.curves must be one of"):
        arguments(estimates)
