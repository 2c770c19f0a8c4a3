"""The structures of the kernel, field by field."""

from __future__ import annotations

import ctypes


class Part(ctypes.Structure):
    """`struct Part`."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("p", "c", "x", "scales", "sums", "guards", "record_x", "record_y")),
        *((name, ctypes.c_void_p) for name in ("failed", "cause")),
        ("front", ctypes.c_int64),
    )


class FrontPart(ctypes.Structure):
    """`struct FrontPart`."""

    _fields_ = tuple((name, ctypes.c_void_p) for name in ("p", "c", "c_near"))


class Runs(ctypes.Structure):
    """`struct Runs`."""

    _fields_ = (
        ("n", ctypes.c_int64),
        ("seeds", ctypes.c_void_p),
        ("parts", ctypes.POINTER(Part)),
        ("fronts", ctypes.POINTER(FrontPart)),
        ("n_fronts", ctypes.c_int64),
        ("noise", ctypes.c_void_p),
    )


class Batch(ctypes.Structure):
    """`struct Batch`."""

    _fields_ = (
        ("h", ctypes.c_double),
        *((name, ctypes.c_int64) for name in ("k", "steps", "hold", "window", "record")),
        ("pulse_on", ctypes.c_void_p),
        ("pulse_off", ctypes.c_void_p),
        ("n_runs", ctypes.c_int64),
        ("runs", ctypes.POINTER(Runs)),
        ("truth", ctypes.POINTER(Runs)),
        ("rows", ctypes.c_void_p),
        ("tile", ctypes.c_int64),
    )


STRUCTURES = (Batch, Runs, Part, FrontPart)
