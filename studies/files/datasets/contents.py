"""The table of contents behind a NetCDF file: which of its bytes are the numbers of which variable.

With it a result is read without HDF5, which damaged or forged bytes can crash, or hold for ever.
"""

from __future__ import annotations

import itertools
import math
import zlib
from collections.abc import Mapping
from types import GenericAlias
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from .schema import read_json

Array = npt.NDArray[Any]

# numbers as they are in a file, little end or big end first; and what is stored as another kind of number
NUMBERS = {
    np.dtype(f"{order}{kind}").str
    for order in "<>"
    for kind in ("f4", "f8", *(f"{s}{2**n}" for s in "iu" for n in range(4)))
}
TEXT, FLAG = "text", "flag"
STORED = {TEXT: np.dtype("S1"), FLAG: np.dtype("i1")} | {name: np.dtype(name) for name in NUMBERS}
# bytes of the length of the table, and of the largest one: 5 GB are some ten thousand chunks, of thirty bytes in it
LENGTH = 8
_LARGEST_TABLE = 20_000_000
# bytes of the texts of a variable; each becomes an object in memory
_LARGEST_TEXTS = 100_000_000

# a text, or the bytes of numbers in hexadecimal digits
_ATTRIBUTES = GenericAlias(dict, (str, {"type": str, "shape": list[int], "value": str}))
# pieces: of each chunk in order its place, its size, and whether it is deflated
_PIECE = 3
_VARIABLE = {
    "dimensions": list[str],
    "type": str,
    "shape": list[int],
    "chunk": list[int],
    "pieces": list[list[int]],
    "attributes": _ATTRIBUTES,
}
_TABLE = {
    "coordinates": list[str],
    "attributes": _ATTRIBUTES,
    "variables": GenericAlias(dict, (str, _VARIABLE)),
}


def read_contents(content: bytes, largest: int) -> xr.Dataset:
    """The Dataset of a file with a table behind it, of `largest` bytes in memory at most.

    ValueError for a table that is none, has another form, or leads out of the file; what else NumPy and xarray raise.
    """
    length = int.from_bytes(content[-LENGTH:], "little")
    if length > min(_LARGEST_TABLE, len(content) - LENGTH):
        raise ValueError("it has no table of contents")
    start = len(content) - LENGTH - length
    table = read_json("table of contents", content[start:-LENGTH].decode(), _TABLE)
    variables, file = table["variables"], memoryview(content)[:start]
    if sum(map(_size, variables.values())) > largest:
        raise ValueError(f"it holds more than {largest:,} bytes")
    # chunks that overlap could hold a thousand times what a file without them can
    if sum(piece[1] for entry in variables.values() for piece in entry["pieces"]) > len(file):
        raise ValueError("its chunks overlap")
    read = {name: _read_variable(entry, file) for name, entry in variables.items()}
    return xr.Dataset(read, attrs=_read_attributes(table["attributes"])).set_coords(table["coordinates"])


def _size(entry: Mapping[str, Any]) -> int:
    """The bytes of all chunks of a variable. ValueError if they are not as many as its shape needs."""
    shape, chunk = entry["shape"], entry["chunk"]
    if len(shape) != len(chunk) or min(shape, default=0) < 0 or min(chunk, default=1) < 1:
        raise ValueError("its shapes are none")
    # ⌈n/c⌉ chunks along each dimension
    count = math.prod(-(-n // c) for n, c in zip(shape, chunk, strict=True))
    if count != len(entry["pieces"]) or any(len(piece) != _PIECE for piece in entry["pieces"]):
        raise ValueError("its chunks are not as its shapes need them")
    length: int = count * math.prod(chunk) * _stored(entry).itemsize
    if entry["type"] == TEXT and length > _LARGEST_TEXTS:
        raise ValueError(f"it holds more than {_LARGEST_TEXTS:,} bytes of text")
    return length


def _stored(entry: Mapping[str, Any]) -> np.dtype[Any]:
    if entry["type"] not in STORED:
        raise ValueError("it holds neither numbers nor texts")
    return STORED[entry["type"]]


def _read_variable(entry: Mapping[str, Any], file: memoryview) -> xr.Variable:
    values = _read_chunks(entry, file)
    if entry["type"] == TEXT:
        texts = values.view(f"S{values.shape[-1]}")[..., 0]
        values = np.char.decode(texts, "utf-8").astype(object)
    elif entry["type"] == FLAG:
        values = values != 0
    return xr.Variable(entry["dimensions"], values, _read_attributes(entry["attributes"]))


def _read_chunks(entry: Mapping[str, Any], file: memoryview) -> Array:
    shape, chunk, stored = entry["shape"], entry["chunk"], _stored(entry)
    values = np.empty(shape, stored)
    if not values.size:
        return values
    corners = itertools.product(*(range(0, n, c) for n, c in zip(shape, chunk, strict=True)))
    for corner, piece in zip(corners, entry["pieces"], strict=True):
        whole = np.frombuffer(_unpacked(file, piece, math.prod(chunk) * stored.itemsize), stored).reshape(chunk)
        # chunks at the end of a dimension reach beyond it
        inside = tuple(slice(min(c, n - start)) for start, c, n in zip(corner, chunk, shape, strict=True))
        values[tuple(slice(start, start + c) for start, c in zip(corner, chunk, strict=True))] = whole[inside]
    return values


def _unpacked(file: memoryview, piece: list[int], length: int) -> bytes | memoryview:
    """The `length` bytes of a chunk; no more are inflated, whatever a forged one holds."""
    place, size, deflated = piece
    if place < 0 or size < 0 or place + size > len(file):
        raise ValueError("a chunk is outside of it")
    raw = file[place : place + size]
    whole = zlib.decompressobj().decompress(raw, length) if deflated else raw
    if len(whole) != length:
        raise ValueError("a chunk has another size than its shape")
    return whole


def _read_attributes(described: Mapping[str, Mapping[str, Any]]) -> dict[str, object]:
    return {
        name: entry["value"]
        if entry["type"] == TEXT
        else np.frombuffer(bytes.fromhex(entry["value"]), _stored(entry)).reshape(entry["shape"]).copy()[()]
        for name, entry in described.items()
    }
