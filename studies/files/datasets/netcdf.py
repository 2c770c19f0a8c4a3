"""Results as NetCDF with a seal behind it: what is read back is what was written."""

from __future__ import annotations

import hashlib
import io
import warnings
from pathlib import Path

import h5py
import xarray as xr

from ..errors import ResultError
from ..quote import escaped, short
from ..reading import cause, read_whole
from ..writing import write_whole
from .hdf5 import refuse_foreign

# bytes of a result, compressed or not; a million recorded points are 1 GB, 10⁸ runs with one score 4 GB
LARGEST_RESULT = 5_000_000_000
_SEAL_SIZE = 40


def save_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """A Dataset as NetCDF, every variable compressed, with a seal behind it. ResultError as for `write_whole`."""
    write_whole(path, netcdf(dataset))


def load(path: str | Path) -> xr.Dataset:
    """A result that `save` or `save_netcdf` has written. ResultError if it is none, damaged, or forged.

    Anyone can seal a file: what is returned is a Dataset, whose variables each reader checks, `Schema`.
    """
    try:
        content = unsealed(read_whole(Path(path), LARGEST_RESULT))
    except (OSError, ValueError) as error:
        raise ResultError(f"{path} cannot be read: {cause(error)}") from error
    if content is None:
        raise ResultError(f"{path} cannot be read: it is no result of hillobs, or it is damaged")
    try:
        return _dataset(content)
    except MemoryError:
        raise
    except Exception as error:  # neither h5py nor xarray says what it raises where a seal is forged
        why = f"it is no result of hillobs: {short(escaped(str(error)))}"
        raise ResultError(f"{path} cannot be read: {why}") from error


def sealed(content: bytes) -> bytes:
    """`content` with a hash behind it."""
    return content + b"hillobs " + hashlib.sha256(content).digest()


def unsealed(raw: bytes) -> bytes | None:
    """What was sealed; None if it is something else, or damaged."""
    content = raw[:-_SEAL_SIZE]
    return content if raw == sealed(content) else None


def _dataset(content: bytes) -> xr.Dataset:
    """The Dataset of a file of which only the seal is known."""
    with h5py.File(io.BytesIO(content), "r") as file:
        refuse_foreign(file, LARGEST_RESULT)
    with warnings.catch_warnings():
        # what xarray would mend with a warning, we have not written
        warnings.simplefilter("error")
        # no number of ours is a date, whatever its unit is called
        with xr.open_dataset(io.BytesIO(content), engine="h5netcdf", decode_times=False) as dataset:
            return dataset.load()


def netcdf(dataset: xr.Dataset) -> bytes:
    """The file in memory, every variable compressed; readers of HDF5 pass over the seal behind it."""
    encoding = {
        str(name): {"zlib": True, "complevel": 1, **({"dtype": "S1"} if variable.dtype.kind in "UO" else {})}
        for name, variable in dataset.variables.items()
    }
    # before HDF5 sees it, which reads damage as other numbers or without end, the seal is checked
    return sealed(bytes(dataset.to_netcdf(engine="h5netcdf", encoding=encoding)))
