"""Results as NetCDF, with a table of contents and a seal behind it: what is read back is what was written."""

from __future__ import annotations

import hashlib
import warnings
from pathlib import Path

import xarray as xr

from ..errors import ResultError
from ..quote import escaped, short
from ..reading import cause, read_whole
from ..writing import write_whole
from .contents import read_contents
from .describing import with_contents

# bytes of a result, compressed or not; a million recorded points are 1 GB, 10⁸ runs with one score 4 GB
LARGEST_RESULT = 5_000_000_000
_SEAL_SIZE = 40


def save_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """A Dataset as NetCDF, every variable compressed, with a seal behind it. ResultError as for `write_whole`."""
    write_whole(path, netcdf(dataset))


def load(path: str | Path) -> xr.Dataset:
    """The result in the file `path`, as commands and `out` have written it.

    ResultError if it is none, damaged, or forged.

    Anyone can seal a file: what is returned is a Dataset, whose variables each reader checks, `Schema`.

    >>> _ = hillobs.sweep("paper-noisy", {"high_gain.eps_h": [0.1, 0.2]}, out="eps.nc")
    >>> hillobs.load("eps.nc").rmse.dims
    ('high_gain.eps_h', 'seed', 'observer', 'quantity')
    """
    try:
        content = unsealed(read_whole(Path(path), LARGEST_RESULT))
    except (OSError, ValueError) as error:
        raise ResultError(f"{path} cannot be read: {cause(error)}") from error
    if content is None:
        raise ResultError(f"{path} cannot be read: it is no result of hillobs, or it is damaged")
    try:
        with warnings.catch_warnings():
            # what xarray would mend with a warning, we have not written
            warnings.simplefilter("error")
            return read_contents(content, LARGEST_RESULT)
    except MemoryError:
        raise
    except Exception as error:  # neither NumPy nor xarray says what it raises where a seal is forged
        why = f"it is no result of hillobs: {short(escaped(str(error)))}"
        raise ResultError(f"{path} cannot be read: {why}") from error


def sealed(content: bytes) -> bytes:
    """`content` with a hash behind it."""
    return content + b"hillobs " + hashlib.sha256(content).digest()


def unsealed(raw: bytes) -> bytes | None:
    """What was sealed; None if it is something else, or damaged."""
    content = raw[:-_SEAL_SIZE]
    return content if raw == sealed(content) else None


def netcdf(dataset: xr.Dataset) -> bytes:
    """The file in memory, every variable compressed; readers of HDF5 pass over table and seal behind it."""
    encoding = {
        str(name): {
            "zlib": True,
            "complevel": 1,
            "shuffle": False,
            **({"dtype": "S1"} if variable.dtype.kind in "UO" else {}),
        }
        for name, variable in dataset.variables.items()
    }
    return sealed(with_contents(bytes(dataset.to_netcdf(engine="h5netcdf", encoding=encoding)), dataset))
