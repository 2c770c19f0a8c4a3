"""Results on disk: whole or absent, bit for bit, and damage is found."""

import csv
import gzip
import io
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from hillobs.studies.files.datasets.netcdf import load
from hillobs.studies.files.errors import ResultError, ScenarioError
from hillobs.studies.files.writing import writable_folder, write_whole
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.simulate.files import measures_csv, save
from hillobs.studies.simulate.run import simulate
from places import DATA, contents

REFERENCE = DATA / "paper_clean.csv.gz"


# what the files of the run below are called
STEM = "slack,duration=0.3,score.start=0.1,seed=5"


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return simulate("slack", changes={"duration": 0.3, "score.start": 0.1, "seed": 5})


def test_what_is_written_is_read_back_bit_for_bit(run: xr.Dataset, tmp_path: Path) -> None:
    broken = run.copy(deep=True)
    broken.x_hat[0, 3:] = np.nan
    save(broken, tmp_path)
    back = load(tmp_path / f"{STEM}.nc")
    for name, variable in broken.variables.items():
        np.testing.assert_array_equal(back[name].values.astype(variable.dtype), variable.values, err_msg=str(name))
    assert back.attrs == broken.attrs
    assert back.x_hat.dims == ("observer", "time", "state")
    assert back.x.attrs == {"long_name": "true states", "units": "1"}


def test_the_csv_begins_with_the_references_columns(run: xr.Dataset, tmp_path: Path) -> None:
    save(run, tmp_path)
    lines = (tmp_path / f"{STEM}.csv").read_text().splitlines()
    with gzip.open(REFERENCE, "rt") as file:
        names = file.readline().strip().split(",")
    header = lines[0].split(",")
    assert header[: len(names)] == names
    assert len(set(header)) == len(header)
    assert {"high_gain.a1_hat", "y1", "y2", "y3", "r"} <= set(header)
    table = np.genfromtxt(lines[1:], delimiter=",")
    np.testing.assert_array_equal(table[:, header.index("x3")], run.x.sel(state="x3"))
    np.testing.assert_array_equal(
        table[:, header.index("sliding_mode.u2_hat")], run.u_hat.sel(observer="sliding_mode", muscle=2)
    )


def test_the_measures_are_a_row_per_observer_and_quantity(run: xr.Dataset) -> None:
    rows = list(csv.DictReader(io.StringIO(measures_csv(run))))
    assert list(rows[0]) == [
        "scenario",
        "seed",
        "observer",
        "quantity",
        "rmse",
        "peak",
        "settling",
        "chattering",
        "masked",
    ]
    assert len(rows) == 4 * 9
    assert {row["seed"] for row in rows} == {"5"}
    row = next(r for r in rows if (r["observer"], r["quantity"]) == ("high_gain", "x2"))
    assert float(row["rmse"]) == float(run.rmse.sel(estimator="high_gain", quantity="x2"))
    assert row["chattering"] == ""


def test_a_file_follows_the_umask_and_replaces_whole(tmp_path: Path) -> None:
    path = tmp_path / "file"
    before = os.umask(0o027)
    try:
        write_whole(path, b"one")
        write_whole(path, b"two")
    finally:
        os.umask(before)
    assert path.read_bytes() == b"two"
    assert path.stat().st_mode & 0o777 == 0o640
    assert contents(tmp_path).keys() == {"file"}


@pytest.mark.parametrize("place", ["file/below", "/dev/null", "/proc/nothing", "\0"])
def test_a_folder_that_cannot_be_written_is_a_sentence(place: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultError, match="cannot be written"):
        writable_folder(tmp_path / place)


FULL_DISK = """
import resource, sys
from pathlib import Path
from hillobs.studies.files.errors import ResultError
from hillobs.studies.files.writing import write_whole
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    write_whole(Path(sys.argv[1]) / "out", b"x" * 5000)
except ResultError as error:
    print(error)
"""


def test_a_full_disk_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    write_whole(tmp_path / "out", b"old")
    done = subprocess.run([sys.executable, "-c", FULL_DISK, tmp_path], capture_output=True, text=True, check=True)
    assert "cannot be written: File too large" in done.stdout
    assert contents(tmp_path) == {"out": b"old"}


FAULTY = """
import errno, os, sys
from pathlib import Path
from hillobs.studies.files.errors import ResultError
from hillobs.studies.files.writing import write_whole
def fault(event, arguments):
    if event == sys.argv[2] and sys.argv[3] in str(arguments[0]):
        raise OSError(errno.EIO, "Input/output error")
sys.addaudithook(fault)
try:
    write_whole(Path(sys.argv[1]) / "out", b"new")
except ResultError as error:
    print(error)
"""


@pytest.mark.parametrize(("event", "near"), [("open", ".out-"), ("os.rename", ".out-"), ("open", ".hillobs-")])
def test_a_fault_at_each_call_leaves_the_old_file(event: str, near: str, tmp_path: Path) -> None:
    write_whole(tmp_path / "out", b"old")
    command = [sys.executable, "-c", FAULTY, tmp_path, event, near]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "out cannot be written: Input/output error" in done.stdout
    assert contents(tmp_path) == {"out": b"old"}


DAMAGED = """
import random, sys
from pathlib import Path
import numpy as np
from hillobs.studies.files.errors import ResultError
from hillobs.studies.files.datasets.netcdf import load
path = Path(sys.argv[1])
good = load(path)
raw = path.read_bytes()
dice = random.Random(int(sys.argv[2]))
counts = {"same": 0, "refused": 0}
for _ in range(int(sys.argv[3])):
    damaged = bytearray(raw)
    damaged[dice.randrange(len(raw))] ^= 1 << dice.randrange(8)
    copy = path.with_name("damaged.nc")
    copy.write_bytes(damaged)
    try:
        back = load(copy)
    except ResultError:
        counts["refused"] += 1
        continue
    for name in good.variables:
        nan = good[name].dtype.kind == "f"
        if name in back.variables and not np.array_equal(good[name], back[name], equal_nan=nan):
            sys.exit(f"{name} changed in silence")
    if {**back.attrs} != {**good.attrs}:
        sys.exit("attributes changed in silence")
    counts["same"] += 1
print(counts)
"""


def test_a_flipped_bit_never_gives_other_numbers(run: xr.Dataset, tmp_path: Path) -> None:
    """96 flips, each refused."""
    save(run.isel(time=slice(0, 8)), tmp_path)
    command = [sys.executable, "-c", DAMAGED, tmp_path / f"{STEM}.nc", "1", "96"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "silence" not in done.stderr, done.stderr
    assert done.returncode == 0, done.stderr[-500:]


@pytest.mark.parametrize("content", [b"", b"not a file", b"\x89HDF\r\n\x1a\n" + b"\0" * 100])
def test_what_is_no_result_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "x.nc"
    path.write_bytes(content)
    with pytest.raises(ResultError, match=r"x\.nc cannot be read"):
        load(path)


@pytest.mark.parametrize("engine", ["h5netcdf", "h5py"])
def test_others_can_read_a_result(engine: str, run: xr.Dataset, tmp_path: Path) -> None:
    """The seal behind the content is no part of the HDF5 file."""
    save(run, tmp_path)
    if engine == "h5py":
        with h5py.File(tmp_path / f"{STEM}.nc") as file:
            np.testing.assert_array_equal(file["x_hat"][:], run.x_hat)
    else:
        with xr.open_dataset(tmp_path / f"{STEM}.nc", engine=engine) as file:
            xr.testing.assert_identical(file.x_hat.load(), run.x_hat)


@pytest.mark.parametrize("read", [load, lambda path: prepare(path, None, {})], ids=["result", "scenario"])
@pytest.mark.parametrize("what", ["pipe", "device", "sparse", "folder"])
def test_only_regular_files_of_some_size_are_read(what: str, read: Callable[[Path], object], tmp_path: Path) -> None:
    path = tmp_path / "x.toml"
    if what == "pipe":
        os.mkfifo(path)
    elif what == "device":
        path.symlink_to("/dev/zero")
    elif what == "folder":
        path.mkdir()
    else:
        path.touch()
        os.truncate(path, 10**10)
    reason = {"sparse": "it is larger than", "folder": "Is a directory"}.get(what, "it is no regular file")
    with pytest.raises((ResultError, ScenarioError), match=f"cannot be read: {reason}"):
        read(path)


def test_a_foreign_netcdf_is_refused(tmp_path: Path) -> None:
    xr.Dataset({"a": ("t", [1.0])}).to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
    with pytest.raises(ResultError, match="no result of hillobs"):
        load(tmp_path / "x.nc")


REFUSES = """
import os, sys
from pathlib import Path
import numpy as np
from hillobs.studies.files.errors import ResultError
from hillobs.studies.files.datasets.netcdf import load
path = Path(sys.argv[1])
good, raw = load(path), path.read_bytes()
pattern, offset, bit = bytes.fromhex(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
places = [i for i in range(len(raw)) if raw.startswith(pattern, i)]
places = places[:: max(1, len(places) // 12)]
copy = path.with_name("damaged.nc")
wrong = []
for place in places:
    damaged = bytearray(raw)
    damaged[place + offset] ^= 1 << bit
    copy.write_bytes(damaged)
    try:
        back = load(copy)
    except ResultError:
        continue
    except Exception as error:
        wrong.append(f"byte {place + offset}: {type(error).__name__}: {error}")
        continue
    for name in good.variables:
        was, now = good[name], back.variables.get(name)
        same = now is not None and np.array_equal(was, now, equal_nan=was.dtype.kind == "f")
        if not same:
            wrong.append(f"byte {place + offset}: {name} has other values")
        elif was.attrs != now.attrs:
            wrong.append(f"byte {place + offset}: {name} has other attributes")
print(len(places))
print("\\n".join(wrong[:5]), file=sys.stderr)
"""

# places of an HDF5 file that a random flip seldom meets: bytes to look for, which of them, which bit
WEAK_PLACES = {
    "entries of a chunk's index": ("545245450100", 6, 2),  # TREE, a node of chunks, level 0
    "exponent bias of a number": ("340b0034ff030000", 4, 0),
    "size of a number": ("11203f0008000000", 4, 2),
    "name of an encoding": (b"utf-8".hex(), 2, 1),
    "a variable's sentence": (b"true ".hex(), 0, 0),
}


@pytest.mark.parametrize("where", WEAK_PLACES)
def test_a_flipped_bit_at_a_weak_place_is_found(where: str, run: xr.Dataset, tmp_path: Path) -> None:
    """Values, labels and attributes are what was written, or there is a sentence; NaN is another number too."""
    save(run.isel(time=slice(0, 8)), tmp_path)
    command = [sys.executable, "-c", REFUSES, tmp_path / f"{STEM}.nc", *map(str, WEAK_PLACES[where])]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-500:]
    if int(done.stdout) == 0:
        pytest.skip("this version of HDF5 lays its files out in another way")
    assert done.stderr.strip() == "", done.stderr


def test_a_number_that_was_changed_is_found(run: xr.Dataset, tmp_path: Path) -> None:
    save(run, tmp_path)
    with h5py.File(tmp_path / f"{STEM}.nc", "r+") as file:
        file["x_hat"][0, 3, 0] += 1.0
    with pytest.raises(ResultError, match="damaged"):
        load(tmp_path / f"{STEM}.nc")


@pytest.mark.parametrize("part", [0.0, 0.001, 0.1, 0.5, 0.9, 0.999])
def test_a_file_that_was_cut_is_refused(part: float, run: xr.Dataset, tmp_path: Path) -> None:
    save(run, tmp_path)
    path = tmp_path / f"{STEM}.nc"
    path.write_bytes(path.read_bytes()[: int(part * path.stat().st_size)])
    with pytest.raises(ResultError, match=r"\.nc cannot be read"):
        load(path)


ODD = [0.0, -0.0, 5e-324, -1e308, 1e-5, 0.1, 1 / 3, 1e22, 123456789.0, float("nan")]


def test_every_double_is_read_back_from_netcdf_and_csv(run: xr.Dataset, tmp_path: Path) -> None:
    odd = run.copy(deep=True)
    odd.x.values[: len(ODD), 0] = ODD
    save(odd, tmp_path)
    back = load(tmp_path / f"{STEM}.nc")
    assert back.x.values.tobytes() == odd.x.values.tobytes()
    with (tmp_path / f"{STEM}.csv").open(newline="") as file:
        texts = [row["x1"] for row in csv.DictReader(file)][: len(ODD)]
    assert np.array([float(t or "nan") for t in texts]).tobytes() == np.array(ODD).tobytes()


@pytest.mark.parametrize("umask", [0o000, 0o077])
def test_results_follow_the_umask(umask: int, run: xr.Dataset, tmp_path: Path) -> None:
    before = os.umask(umask)
    try:
        save(run, tmp_path)
    finally:
        os.umask(before)
    assert {(tmp_path / name).stat().st_mode & 0o777 for name in contents(tmp_path)} == {0o666 & ~umask}


def test_a_disk_that_fills_up_leaves_whole_files_or_none(run: xr.Dataset, tmp_path: Path) -> None:
    """NetCDF, time series and measures: what is there under a final name is complete."""
    save(run, tmp_path)
    sizes = ["60000", "20000", "1"]
    for size in sizes:
        (tmp_path / size).mkdir()
    command = [sys.executable, "-c", SAVE, f"{STEM}.nc", *sizes]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("cannot be written: File too large") == len(sizes)
    for size in sizes:
        for name, content in contents(tmp_path / size).items():
            assert name.endswith(".csv")
            assert content == (tmp_path / name).read_bytes()


SAVE = """
import resource, sys
from pathlib import Path
from hillobs.studies.files.errors import ResultError
from hillobs.studies.files.datasets.netcdf import load
from hillobs.studies.simulate.files import save
run = load(Path(sys.argv[1]))
# a limit may only fall
for size in sys.argv[2:]:
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(size),) * 2)
    try:
        save(run, Path(size))
    except ResultError as error:
        print(error)
"""
