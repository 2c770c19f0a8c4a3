"""What a file's table of contents says is what HDF5 reads: types, shapes, chunks, texts and attributes."""

import io
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from hillobs.studies.files.datasets.netcdf import load, save_netcdf, unsealed

GENERATOR = np.random.default_rng(0)
# HDF5 cuts what is larger than some kilobytes into chunks; the last ones reach beyond the end
CHUNKED = (7, 301, 503)
VALUES = {
    **{kind: GENERATOR.integers(0, 100, (4, 3)).astype(kind) for kind in ("i1", "i2", "i4", "i8", "u1", "u4", "u8")},
    **{kind: GENERATOR.normal(size=(4, 3)).astype(kind) for kind in ("f4", "f8")},
    "largest whole number": np.array([2**64 - 1], "u8"),
    "flags": np.array([True, False, True]),
    "one number": np.array(2.5),
    "one text": np.array("größer"),
    "texts": np.array([["a", "", "≥ λ₁₁"], ["x" * 300, " ", "\U0001f4aa"]]),
    "texts without letters": np.array(["", ""]),
    "no numbers": np.zeros((3, 0, 2)),
    "no texts": np.array([], "U5"),
    "chunks": GENERATOR.normal(size=CHUNKED),
    "chunks of whole numbers": GENERATOR.integers(0, 2, CHUNKED).astype("i2"),
}


@pytest.mark.parametrize("values", VALUES.values(), ids=VALUES)
def test_a_variable_is_read_as_hdf5_reads_it(values: np.ndarray, tmp_path: Path) -> None:
    dimensions = [f"d{axis}" for axis in range(values.ndim)]
    about = {"units": "m/s", "scale": 0.1, "count": 3, "flag_values": np.arange(3, dtype="i2"), "comment": "λ"}
    written = xr.Dataset(
        {"x": (dimensions, values, about), "beside": (dimensions, values)}, attrs={"title": "", **about}
    )
    save_netcdf(written.set_coords("beside"), tmp_path / "x.nc")
    read = load(tmp_path / "x.nc")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = io.BytesIO(unsealed((tmp_path / "x.nc").read_bytes()))
        with xr.open_dataset(file, engine="h5netcdf", decode_times=False) as dataset:
            xr.testing.assert_identical(read, dataset.load())
    assert read.x.dtype == dataset.x.dtype
    assert read.x.values.tobytes() == dataset.x.values.tobytes() or read.x.dtype == object
    for attributes, same in ((read.attrs, dataset.attrs), (read.x.attrs, dataset.x.attrs)):
        assert list(attributes) == list(same)
        assert all(np.asarray(attributes[name]).dtype == np.asarray(same[name]).dtype for name in same)


def test_a_large_variable_is_in_chunks(tmp_path: Path) -> None:
    """Else the cases above would not show how they are put together."""
    save_netcdf(xr.Dataset({"x": (("a", "b", "c"), VALUES["chunks"])}), tmp_path / "x.nc")
    with xr.open_dataset(io.BytesIO(unsealed((tmp_path / "x.nc").read_bytes())), engine="h5netcdf") as dataset:
        chunk = dataset.x.encoding["chunksizes"]
    assert sum(n % c > 0 for n, c in zip(CHUNKED, chunk, strict=True)) > 1
