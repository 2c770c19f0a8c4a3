"""The table of contents of a NetCDF file that we have just written: HDF5 says where it has put which chunk."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from typing import Any

import h5py
import numpy as np
import xarray as xr
from h5py import h5z

from .contents import FLAG, LENGTH, NUMBERS, STORED, TEXT


def with_contents(netcdf: bytes, dataset: xr.Dataset) -> bytes:
    """The NetCDF file that `dataset` was written to, with the table of its contents behind it.

    TypeError for attributes or variables that are neither numbers nor texts.
    """
    with h5py.File(io.BytesIO(netcdf), "r") as file:
        variables = {str(name): _described(file[str(name)], variable) for name, variable in dataset.variables.items()}
    coordinates = [str(name) for name in dataset.coords]
    table = {"coordinates": coordinates, "attributes": _attributes(dataset.attrs), "variables": variables}
    text = json.dumps(table, separators=(",", ":")).encode()
    return netcdf + (text + len(text).to_bytes(LENGTH, "little"))


def _described(stored: h5py.Dataset, variable: xr.Variable) -> dict[str, object]:
    """What the table says of a variable."""
    kind = {"U": TEXT, "O": TEXT, "b": FLAG}.get(variable.dtype.kind, stored.dtype.str)
    if STORED.get(kind) != stored.dtype:
        raise TypeError(f"{stored.name} has neither numbers nor texts")
    return {
        "dimensions": list(map(str, variable.dims)),
        "type": kind,
        "shape": list(stored.shape),
        "chunk": list(stored.chunks or (max(n, 1) for n in stored.shape)),
        "pieces": list(_pieces(stored)),
        "attributes": _attributes(variable.attrs),
    }


def _pieces(stored: h5py.Dataset) -> Iterator[tuple[int, int, int]]:
    """Place, size, and whether it is deflated, of each chunk in order."""
    properties = stored.id.get_create_plist()
    filters = [properties.get_filter(place)[0] for place in range(properties.get_nfilters())]
    if filters not in ([], [h5z.FILTER_DEFLATE]):
        raise TypeError(f"{stored.name} is compressed in another way")
    if not stored.size:
        return
    if stored.chunks is None:
        yield stored.id.get_offset(), stored.nbytes, 0
        return
    chunks: list[Any] = []
    stored.id.chunk_iter(chunks.append)
    for chunk in sorted(chunks):
        # the mask has a bit for each filter that HDF5 has left out
        yield chunk.byte_offset, chunk.size, int(bool(filters) and not chunk.filter_mask)


def _attributes(attributes: Mapping[Any, object]) -> dict[str, object]:
    described: dict[str, object] = {}
    for name, value in attributes.items():
        array = np.asarray(value)
        if not isinstance(value, str) and array.dtype.str not in NUMBERS:
            raise TypeError(f"the attribute {name} is neither numbers nor text")
        kind, content = (TEXT, value) if isinstance(value, str) else (array.dtype.str, array.tobytes().hex())
        described[str(name)] = {"type": kind, "shape": list(array.shape), "value": content}
    return described
