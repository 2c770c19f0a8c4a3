"""Load a verified library and call its functions by name."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ..model.arrays import Array
from .cache import ABI, BuildError
from .export import Source, export_functions
from .toolchain import NATIVE, build

_DOUBLES = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")


def open_library(path: Path) -> ctypes.CDLL:
    """Return the loaded library at an absolute path that `toolchain.build` has verified."""
    if not path.is_absolute():
        raise BuildError(f"A library is loaded by its absolute path only, not by {str(path)!r}.")
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise BuildError(_explain(path, str(error))) from error
    try:
        abi = library.hillobs_abi
    except AttributeError as error:
        raise BuildError(f"{path} is no library of hillobs: it exports no hillobs_abi.") from error
    abi.restype, abi.argtypes = ctypes.c_int, ()
    if (found := abi()) != ABI:
        raise BuildError(f"{path} has the binary interface {found}, but this hillobs speaks {ABI}.")
    return library


def load(source: Source, target: str = NATIVE) -> tuple[Path, ctypes.CDLL]:
    """Path and library of a Source, compiled for `target` unless the cache has it. BuildError if that fails."""
    path = build(source.text, source.description, target)
    return path, open_library(path)


class Library:
    """Compiled functions, by name."""

    def __init__(self, functions: Sequence[ca.Function], target: str = NATIVE) -> None:
        self.path, self.dll = load(export_functions(functions), target)
        self.dll.hillobs_call.argtypes = (ctypes.c_int64, ctypes.c_int64, _DOUBLES, _DOUBLES)
        self.dll.hillobs_call.restype = ctypes.c_int
        self._functions: Mapping[str, tuple[int, ca.Function]] = {
            function.name(): (index, function) for index, function in enumerate(functions)
        }

    def call(self, name: str, *arguments: ArrayLike) -> list[Array]:
        """The function at many points.

        Each argument has the shape (points, size) or (size,), which is then the same at all points; matrices are
        given column by column. Each result has the shape (points, size). ValueError for a wrong name or size.
        """
        if name not in self._functions:
            raise ValueError(f"no function {name!r}; there are {', '.join(self._functions)}")
        index, function = self._functions[name]
        sizes = [function.numel_in(i) for i in range(function.n_in())]
        columns = [np.atleast_2d(np.asarray(argument, dtype=float)) for argument in arguments]
        if [column.shape[-1] for column in columns] != sizes:
            raise ValueError(f"{name} takes arguments of the sizes {sizes}, not {[c.shape[-1] for c in columns]}")
        points = max((len(column) for column in columns), default=1)
        given = np.hstack([np.broadcast_to(c, (points, c.shape[-1])) for c in columns])
        widths = [function.numel_out(i) for i in range(function.n_out())]
        results = np.empty((points, sum(widths)))
        self.dll.hillobs_call(index, points, np.ascontiguousarray(given), results)
        return np.split(results, np.cumsum(widths)[:-1], axis=1)


def compile_functions(functions: Sequence[ca.Function], target: str = NATIVE) -> Library:
    """The functions as compiled C, for the processors of `target`."""
    return Library(functions, target)


def _explain(path: Path, words: str) -> str:
    """Return the loader's words as a sentence that says what to do."""
    if "failed to map segment" in words or "code signature" in words:
        return f"{path} cannot be run: {path.parent} is mounted noexec; name another folder in HILLOBS_CACHE."
    return f"{path} cannot be loaded: {words}."
