"""What a user of CasADi would do: export the right-hand side as C, compile it, write a loop around it."""

from __future__ import annotations

import ctypes
import os
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

import casadi as ca
import numpy as np

from hillobs.codegen.toolchain import NATIVE, TARGETS
from hillobs.model.arrays import Array

from ..problem import Problem, right_hand_side
from . import AbsentError, Contender, marching

_STEPS = 2_000
_LOOP = Path(__file__).with_name("rk4.c")
_FLAGS = ("-O3", *TARGETS[NATIVE], "-fPIC", "-shared")


def exported(of: Problem) -> Contender:
    """The wired Block as it stands."""
    f, numbers = right_hand_side(of)
    return _contender(f"CasADi's C as exported, {' '.join(_FLAGS[:2])}", of, f, numbers, "CasADi's C")


def shared(of: Problem) -> Contender:
    """The same with the numbers written in, after `ca.cse`."""
    f, numbers = right_hand_side(of)
    t, x, w = (ca.SX.sym(name, *f.size_in(name)) for name in ("t", "x", "w"))
    rates = ca.cse(f(t, x, numbers, w))
    whole = ca.Function(f.name(), [t, x, ca.SX(0, 1), w], [rates], f.name_in(), f.name_out())
    return _contender("… numbers written in, after ca.cse", of, whole, [])


def _contender(name: str, of: Problem, f: ca.Function, numbers: list[float], reference: str = "") -> Contender:
    march = _compiled(f, len(of.loop.noise))
    p = np.array([*numbers, 0.0])

    def run(samples: Array) -> Array:
        x, w = of.x0.copy(), np.ascontiguousarray(samples[:, :, 0])
        march(x.ctypes.data, p.ctypes.data, w.ctypes.data, of.grid.h, _STEPS, of.grid.hold)
        return x[:, None]

    return marching(name, of, 1, _STEPS, run, reference=reference)


def _compiled(f: ca.Function, channels: int) -> ctypes._NamedFuncPointer:
    compiler = shlex.split(os.environ.get("CC", "gcc"))
    if shutil.which(compiler[0]) is None:
        raise AbsentError(f"{compiler[0]} is not installed")
    generator = ca.CodeGenerator("whole.c")
    generator.add(f)
    sizes = [f"-DF={f.name()}", f"-DSTATES={f.numel_out(0)}", f"-DCHANNELS={channels}"]
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(f"{folder}/")
        command = [*compiler, *_FLAGS, *sizes, "whole.c", str(_LOOP), "-o", "whole.so", "-lm"]
        subprocess.run(command, cwd=folder, check=True)
        march = ctypes.CDLL(f"{folder}/whole.so").march
    march.argtypes = (*[ctypes.c_void_p] * 3, ctypes.c_double, ctypes.c_long, ctypes.c_long)
    march.restype = None
    return march
