"""Results as someone else might forge them: a good one, changed, with a seal that fits again."""

import json
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr

from hillobs.studies.files.datasets.netcdf import sealed, unsealed

Mutation = Callable[[xr.Dataset], xr.Dataset]

NONSENSE = [
    "",
    "null",
    "[]",
    "{}",
    '"x"',
    "1e999",
    "[" * 5000,
    "{",
    '{"a": {"b": 1}}',
    '{"plant.drive": "x"}',
    "9" * 5000,
]


def mutations(good: xr.Dataset) -> Iterator[tuple[str, Mutation]]:
    """Every variable and every attribute of a result in turn: gone, renamed, of another type, shape or size."""
    for name in map(str, good.variables):
        yield f"{name} gone", lambda d, n=name: d.drop_vars(n)
        yield f"{name} renamed", lambda d, n=name: d.rename({n: "other"})
        for dtype in ("f4", "i1", "U3", "c16", "M8[ns]", "?"):
            yield f"{name} as {dtype}", lambda d, n=name, t=dtype: _with(d, n, np.zeros(d[n].shape).astype(t))
        if good[name].dtype.kind in "fiu":
            for value in (np.nan, np.inf, 1e308, -1.0, 0.0, 5e-324):
                yield f"{name} all {value}", lambda d, n=name, v=value: _with(d, n, _full(d[n], v))
        if good[name].dtype.kind in "UO":
            for text in ("", "\x1b[31m", "$a_{", "../../x", "x" * 500):
                yield f"{name} all {text!r:.9}", lambda d, n=name, t=text: _with(d, n, np.full(d[n].shape, t))
        if good[name].ndim > 1:
            yield f"{name} turned", lambda d, n=name: d.assign({n: d[n].transpose(*reversed(d[n].dims))})
    for dimension in map(str, good.dims):
        yield f"no {dimension}", lambda d, n=dimension: d.isel({n: slice(0, 0)})
        yield f"one {dimension}", lambda d, n=dimension: d.isel({n: slice(0, 1)})
        yield f"{dimension} twice", lambda d, n=dimension: d.isel({n: [0, 0]})
        yield f"{dimension} backwards", lambda d, n=dimension: d.isel({n: slice(None, None, -1)})
    for name in good.attrs:
        yield (
            f"no attribute {name}",
            lambda d, n=name: (
                d.assign_attrs({})
                .drop_attrs(deep=False)
                .assign_attrs({key: value for key, value in d.attrs.items() if key != n})
            ),
        )
        for value in (1.5, np.arange(3), *NONSENSE):
            yield f"{name} = {value!s:.9}", lambda d, n=name, v=value: d.assign_attrs({n: v})
        for changed in _changed_json(good.attrs[name]):
            yield f"{name} = {changed:.30}", lambda d, n=name, v=changed: d.assign_attrs({n: v})
    for name in map(str, good.variables):
        for key in good[name].attrs:
            for value in ("x", 1.5, np.arange(3), np.nan):
                yield f"{name}.{key} = {value}", lambda d, n=name, k=key, v=value: _about(d, n, k, v)
        for key, value in (
            ("scale_factor", "x"),
            ("coordinates", "x"),
            ("units", "days since 2000-01-01"),
            ("dtype", "bool"),
        ):
            yield f"{name}.{key} = {value}", lambda d, n=name, k=key, v=value: _about(d, n, k, v)


def opened(raw: bytes) -> tuple[bytes, bytes]:
    """The NetCDF file in a result, and its table of contents."""
    content = unsealed(raw) or b""
    end = len(content) - 8
    start = end - int.from_bytes(content[end:], "little")
    return content[:start], content[start:end]


def retabled(raw: bytes, change: Callable[[dict[str, Any]], object]) -> bytes:
    """A result whose table of contents someone has changed, sealed."""
    netcdf, text = opened(raw)
    table = json.loads(text)
    change(table)
    return with_table(netcdf, json.dumps(table).encode())


def with_table(netcdf: bytes, table: bytes) -> bytes:
    """A file with a table behind it, sealed."""
    return sealed(netcdf + table + len(table).to_bytes(8, "little"))


def _in_every(key: str, change: Callable[[Any], object]) -> Callable[[dict[str, Any]], object]:
    """What becomes of this of each variable."""

    def changed(table: dict[str, Any]) -> None:
        for entry in table["variables"].values():
            entry[key] = change(entry[key])

    return changed


def _in_pieces(change: Callable[[list[int]], object]) -> Callable[[dict[str, Any]], object]:
    return _in_every("pieces", lambda pieces: [change(piece) for piece in pieces])


def _attribute(value: object) -> Callable[[dict[str, Any]], object]:
    return lambda table: table["attributes"].update(title=value)


def _variable(name: str = "odd", **changes: object) -> Callable[[dict[str, Any]], object]:
    """Another variable beside those that are there."""
    odd = {"dimensions": [], "type": "<f8", "shape": [], "chunk": [], "pieces": [[0, 8, 0]], "attributes": {}}
    return lambda table: table["variables"].update({name: {**odd, **changes}})


# tables of contents that lead out of the file, claim too much, or make no sense
TABLES = {
    "chunks beyond the end": _in_pieces(lambda piece: [piece[0] + 10**7, *piece[1:]]),
    "chunks before the beginning": _in_pieces(lambda piece: [-piece[0], *piece[1:]]),
    "chunks of negative size": _in_pieces(lambda piece: [piece[0], -piece[1], piece[2]]),
    "chunks of no size": _in_pieces(lambda piece: [piece[0], 0, piece[2]]),
    "chunks at an enormous place": _in_pieces(lambda piece: [10**30, *piece[1:]]),
    "chunks that are not deflated": _in_pieces(lambda piece: [*piece[:2], 0]),
    "chunks with one number": _in_pieces(lambda piece: piece[:1]),
    "chunks that are texts": _in_pieces(lambda piece: "place"),
    "chunks cut off": _in_pieces(lambda piece: [piece[0], piece[1] // 2, piece[2]]),
    "chunks that overlap": lambda table: [
        _variable(f"odd{i}", dimensions=["far"], type="|i1", shape=[9000], chunk=[9000], pieces=[[0, 9000, 0]])(table)
        for i in range(100)
    ],
    "chunks elsewhere": _in_pieces(lambda piece: [1, *piece[1:]]),
    "no chunks": _in_every("pieces", lambda pieces: []),
    "chunks twice": _in_every("pieces", lambda pieces: pieces * 2),
    "shapes of a tenth dimension": _in_every("shape", lambda shape: [*shape, 1]),
    "shapes that are too long": _in_every("shape", lambda shape: [10**15 for _ in shape]),
    "shapes that no machine can count": _in_every("shape", lambda shape: [10**40 for _ in shape]),
    "shapes below zero": _in_every("shape", lambda shape: [-n for n in shape]),
    "chunks that are too long": _in_every("chunk", lambda chunk: [10**15 for _ in chunk]),
    "chunks of another size": _in_every("chunk", lambda chunk: [2 * n for n in chunk]),
    "chunks of nothing": _in_every("chunk", lambda chunk: [0 for _ in chunk]),
    "objects for numbers": _in_every("type", lambda kind: "|O"),
    "numbers as text": _in_every("type", lambda kind: "text"),
    "numbers that NumPy alone knows": _in_every("type", lambda kind: "f8,f8"),
    "dimensions without names": _in_every("dimensions", lambda names: []),
    "dimensions of one name": _in_every("dimensions", lambda names: ["time" for _ in names]),
    "dimensions that are numbers": _in_every("dimensions", lambda names: [1 for _ in names]),
    "coordinates that are not there": lambda table: table["coordinates"].append("nowhere"),
    "no variables": lambda table: table.pop("variables"),
    "variables in a list": lambda table: table.update(variables=list(table["variables"].values())),
    "something beside": lambda table: table.update(beside=1),
    "an attribute that is a number": _attribute(1.0),
    "an attribute without digits": _attribute({"type": "<f8", "shape": [], "value": "xyz"}),
    "an attribute that is too short": _attribute({"type": "<f8", "shape": [], "value": "00"}),
    "an attribute of another shape": _attribute({"type": "<f8", "shape": [3], "value": "00" * 8}),
    "an attribute of an enormous shape": _attribute({"type": "<f8", "shape": [10**30, 0], "value": ""}),
    "a text without letters": _variable(type="text"),
    "a variable that is in the file's middle as it is": _variable(pieces=[[10**6, 8, 0]]),
    "a text that is no UTF-8": _variable(type="text", shape=[8], chunk=[8]),
    "more dimensions than NumPy has": _variable(
        dimensions=[f"d{i}" for i in range(100)], shape=[1] * 100, chunk=[1] * 100
    ),
}  # fmt: skip


def _with(dataset: xr.Dataset, name: str, values: object) -> xr.Dataset:
    return dataset.assign({name: (dataset[name].dims, values, dataset[name].attrs)})


def _full(array: xr.DataArray, value: float) -> object:
    with np.errstate(all="ignore"):
        return np.full(array.shape, value).astype(array.dtype)


def _about(dataset: xr.Dataset, name: str, key: str, value: object) -> xr.Dataset:
    changed = dataset.copy()
    changed[name].attrs[key] = value
    return changed


def _changed_json(text: object) -> Iterator[str]:
    """A text that is JSON, with one entry gone, of another type, or no number."""
    try:
        content = json.loads(str(text))
    except ValueError:
        return
    if isinstance(content, dict):
        for key in content:
            yield json.dumps({other: value for other, value in content.items() if other != key})
            yield from (json.dumps({**content, key: value}) for value in ("x", None, 1e308, -1, float("nan"), [], {}))
