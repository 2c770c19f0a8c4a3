"""Results as files: NetCDF and CSV, whole or not at all."""

from __future__ import annotations

import contextlib
import csv
import hashlib
import io
import os
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from ..codegen.library import Array
from ..model.symbols import MEASURED, STATES, hat
from .measures import KINDS
from .reading import cause, read_whole

# an observer's estimates in the order of a CSV file; its further states follow
_ESTIMATES = ("x1_hat", "x2_hat", "Delta_hat", "x3_hat", "u1_hat", "x4_hat", "u2_hat")
# bytes of a result, compressed or not; a million recorded points are 1 GB, 10⁸ runs with one score 4 GB
LARGEST_RESULT = 5_000_000_000
_SEAL_SIZE = 40


class ResultError(ValueError):
    """A result that cannot be written or read; the sentence says which and why."""


def write_whole(path: Path, content: bytes, folder: Path | None = None) -> None:
    """`content` under `path`, or nothing new there. ResultError names the file and the cause.

    folder: where it is written before it gets its name; beside `path` by default.
    """
    write_pieces(path, [content], folder)


def write_pieces(path: Path, pieces: Iterable[bytes], folder: Path | None = None) -> None:
    """The pieces, one after the other, as one file under `path`, or nothing new there. As above."""
    try:
        handle, temporary = tempfile.mkstemp(dir=folder or path.parent, prefix=f".{path.name[:40]}-")
        try:
            with os.fdopen(handle, "wb") as file:
                file.writelines(pieces)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(temporary, 0o666 & ~_umask())
            os.replace(temporary, path)
        except BaseException:  # a signal too leaves nothing half written
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
        _sync_folder(path.parent)
    except OSError as error:
        raise ResultError(f"{path} cannot be written: {error.strerror}") from error


def writable_folder(folder: Path) -> Path:
    """`folder`, created if need be and proved writable. ResultError otherwise."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except FileExistsError as error:
        raise ResultError(f"{folder} cannot be written to: it is not a folder") from error
    except (OSError, ValueError) as error:
        raise ResultError(f"{folder} cannot be written to: {cause(error)}") from error


def refuse_same_names(names: Sequence[str]) -> None:
    """ResultError if two results would be written under one name."""
    if double := sorted({name for name in names if names.count(name) > 1}):
        raise ResultError(f"two scenarios are called {double[0]}: their results would overwrite each other")


def save(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """The Dataset as NetCDF, its time series and its measures as CSV; the paths written."""
    stem = dataset.attrs["scenario"]
    contents = {
        f"{stem}.nc": _netcdf(dataset),
        f"{stem}.csv": _time_series(dataset).encode(),
        f"{stem}-measures.csv": measures_csv(dataset).encode(),
    }
    for name, content in contents.items():
        write_whole(folder / name, content)
    return [folder / name for name in contents]


def save_netcdf(dataset: xr.Dataset, path: Path, folder: Path | None = None) -> None:
    """A Dataset as NetCDF, every variable compressed, with a seal behind it; `folder` as for `write_whole`."""
    write_whole(path, _netcdf(dataset), folder)


def load(path: Path) -> xr.Dataset:
    """A result that `save` or `save_netcdf` has written. ResultError if it is none, or damaged."""
    try:
        content = unsealed(read_whole(path, LARGEST_RESULT))
    except (OSError, ValueError) as error:
        raise ResultError(f"{path} cannot be read: {cause(error)}") from error
    if content is None:
        raise ResultError(f"{path} cannot be read: it is no result of hillobs, or it is damaged")
    with xr.open_dataset(io.BytesIO(content), engine="h5netcdf") as file:
        return file.load()


def sealed(content: bytes) -> bytes:
    """`content` with a hash behind it."""
    return content + b"hillobs " + hashlib.sha256(content).digest()


def unsealed(raw: bytes) -> bytes | None:
    """What was sealed; None if it is something else, or damaged."""
    content = raw[:-_SEAL_SIZE]
    return content if raw == sealed(content) else None


def columns(dataset: xr.Dataset) -> Iterator[tuple[str, str, Array]]:
    """Name, unit and values of each column of the time series, in order."""
    observers = dataset.observer.values.tolist()
    yield "t", *_series(dataset.time)
    for state in STATES:
        yield state, *_series(dataset.x.sel(state=state))
    for observer in observers:
        for name in _ESTIMATES:
            yield f"{observer}.{name}", *_series(_estimate(dataset, observer, name))
        for variable in dataset.data_vars.values():
            if variable.attrs.get("observer") == observer:
                yield f"{observer}.{variable.attrs['state']}", *_series(variable)
    for name in ("u1", "u2", "Delta", "a1", "a2"):
        yield name, *_series(_truth(dataset, name))
    for observer in observers:
        for name in ("a1_hat", "a2_hat"):
            yield f"{observer}.{name}", *_series(_estimate(dataset, observer, name))
    for name in MEASURED:
        yield name, *_series(dataset.y.sel(sensor=name))
    if "r" in dataset:
        yield "r", *_series(dataset.r)


def measures_csv(dataset: xr.Dataset) -> str:
    """One row per estimator and quantity; empty where a measure is not defined."""
    keys = list(KINDS)
    rows = [
        [dataset.attrs["scenario"], dataset.attrs["seed"], estimator, quantity]
        + [_written(float(dataset[key].sel(estimator=estimator, quantity=quantity))) for key in keys]
        for estimator in dataset.estimator.values
        for quantity in dataset.quantity.values
    ]
    return _csv([["scenario", "seed", "observer", "quantity", *keys], *rows])


def _time_series(dataset: xr.Dataset) -> str:
    every = list(columns(dataset))
    units = "# units: " + ",".join(unit for _, unit, _ in every) + "\n"
    rows = np.stack([values for _, _, values in every], axis=1).tolist()
    return units + _csv([[name for name, _, _ in every], *([_written(value) for value in row] for row in rows)])


def _truth(dataset: xr.Dataset, name: str) -> xr.DataArray:
    return dataset["Delta"] if name == "Delta" else dataset[name[0]].sel(muscle=int(name[1]))


def _estimate(dataset: xr.Dataset, observer: str, name: str) -> xr.DataArray:
    of = dataset.sel(observer=observer)
    quantity = name.removesuffix(hat(""))
    if quantity == "Delta":
        return of["Delta_hat"]
    return of["x_hat"].sel(state=quantity) if quantity in STATES else of[hat(quantity[0])].sel(muscle=int(quantity[1]))


def _series(array: xr.DataArray) -> tuple[str, Array]:
    return array.attrs.get("units", "1"), array.values


def _csv(rows: list[list[str]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _written(value: float) -> str:
    """The shortest text that reads back as the same number; NaN is empty."""
    return "" if value != value else repr(value).removesuffix(".0")


def _netcdf(dataset: xr.Dataset) -> bytes:
    """The file in memory, every variable compressed; readers of HDF5 pass over the seal behind it."""
    encoding = {
        str(name): {"zlib": True, "complevel": 1, **({"dtype": "S1"} if variable.dtype.kind == "U" else {})}
        for name, variable in dataset.variables.items()
    }
    # before HDF5 sees it, which reads damage as other numbers or without end, the seal is checked
    return sealed(bytes(dataset.to_netcdf(engine="h5netcdf", encoding=encoding)))


def _sync_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
