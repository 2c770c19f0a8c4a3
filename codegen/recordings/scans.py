"""Compiled functions that are carried over the rows of a recording, forwards or backwards."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ...model.arrays import Array
from ..export import export_functions
from ..shared_library import load
from ..toolchain import SINGLE


class _Scan(ctypes.Structure):
    """`struct Scan`."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("p", "carry", "rows", "results")),
        ("n", ctypes.c_int64),
        ("backwards", ctypes.c_int64),
        ("window", ctypes.c_int64),
    )


@dataclass(frozen=True)
class Scanned:
    """What is carried at the end, and the results (rows × size)."""

    carry: Array
    results: Array


class Scans:
    """Functions (p, carry, row, …) → (carry, result) as a loaded library; each row is one of a table of its own."""

    def __init__(self, functions: Sequence[ca.Function], target: str = SINGLE) -> None:
        self.path, self.dll = load(export_functions(functions, "scan.cpp"), target)
        self.dll.hillobs_scan.argtypes = (ctypes.c_int64, ctypes.POINTER(_Scan))
        self.dll.hillobs_scan.restype = ctypes.c_int
        self._functions: Mapping[str, tuple[int, ca.Function]] = {
            function.name(): (index, function) for index, function in enumerate(functions)
        }

    def run(
        self, name: str, p: ArrayLike, carry: ArrayLike, *tables: Array, backwards: bool = False, window: int = 0
    ) -> Scanned:
        """The function from row to row of tables of equal length; from the last to the first if `backwards`.

        window: each row is reached from that many rows ahead, where `carry` begins anew. ValueError for sizes that are
        not the function's.
        """
        index, function = self._functions[name]
        given = [np.array(p, dtype=float).ravel(), np.array(carry, dtype=float).ravel()]
        rows = [np.ascontiguousarray(table, dtype=float) for table in tables]
        sizes = [*(len(vector) for vector in given), *(table.shape[1] for table in rows)]
        if sizes != [function.numel_in(i) for i in range(function.n_in())] or len({len(table) for table in rows}) != 1:
            raise ValueError(f"{name} takes {function}, not arguments of the sizes {sizes}")
        results = np.empty((len(rows[0]), function.numel_out(1)))
        pointers = (ctypes.c_void_p * len(rows))(*(table.ctypes.data for table in rows))
        self.dll.hillobs_scan(
            index,
            _Scan(
                p=given[0].ctypes.data,
                carry=given[1].ctypes.data,
                rows=ctypes.addressof(pointers),
                results=results.ctypes.data,
                n=len(rows[0]),
                backwards=int(backwards),
                window=window,
            ),
        )
        return Scanned(given[1], results)
