"""Results as someone else might forge them: a good one, changed, with a seal that fits again."""

import io
import json
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np
import xarray as xr

from hillobs.studies.files.datasets.netcdf import sealed

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


def rebuilt(content: bytes, change: Callable[[h5py.File], None]) -> bytes:
    """The HDF5 file in `content` after `change`, sealed."""
    file = io.BytesIO(content)
    with h5py.File(file, "r+") as opened:
        change(opened)
    return sealed(file.getvalue())


def _soft(file: h5py.File) -> None:
    file["linked"] = h5py.SoftLink("/time")


def _external_link(file: h5py.File) -> None:
    file["linked"] = h5py.ExternalLink("/etc/passwd", "/")


def _external_storage(file: h5py.File) -> None:
    file.create_dataset("outside", (8,), "u1", external=[(str(Path(__file__)), 0, 8)])


def _virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout((8,), "f8")
    layout[:] = h5py.VirtualSource("other.h5", "a", (8,))
    file.create_virtual_dataset("virtual", layout)


def _group(file: h5py.File) -> None:
    file.create_group("inner")["a"] = 1.0


def _compound(file: h5py.File) -> None:
    file["table"] = np.zeros(3, dtype=[("a", "f8"), ("b", "i4")])


def _reference(file: h5py.File) -> None:
    file.create_dataset("pointer", data=file["time"].ref, dtype=h5py.ref_dtype)


def _any_length(file: h5py.File) -> None:
    file.create_dataset("texts", (3,), h5py.string_dtype())


def _another_filter(file: h5py.File) -> None:
    file.create_dataset("packed", data=np.zeros(1000), compression="lzf")


def _huge(file: h5py.File) -> None:
    file.create_dataset("huge", (10**12,), "f8", chunks=(10**6,), compression="gzip")


def _named_type(file: h5py.File) -> None:
    file["type"] = np.dtype("f8")


def _compound_attribute(file: h5py.File) -> None:
    file.attrs["table"] = np.zeros(3, dtype=[("a", "f8"), ("b", "i4")])


def _pointer_attribute(file: h5py.File) -> None:
    file.attrs.create("pointer", file["time"].ref, dtype=h5py.ref_dtype)


def _empty(file: h5py.File) -> None:
    file["nothing"] = h5py.Empty("f8")


CONTAINERS = (
    _soft, _external_link, _external_storage, _virtual, _group, _compound, _reference, _any_length, _another_filter,
    _huge, _named_type, _compound_attribute, _pointer_attribute, _empty,
)  # fmt: skip


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
