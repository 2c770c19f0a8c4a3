"""The machine and the programs that were measured."""

from __future__ import annotations

import platform
from importlib import metadata

from hillobs.codegen.cache import BuildError
from hillobs.codegen.system.processor import cpuinfo, features
from hillobs.codegen.toolchain import find_compiler

_PACKAGES = ("casadi", "numpy", "scipy", "numba", "jax")
# of /proc/cpuinfo, on x86 and elsewhere
_MODEL = ("model name", "Model", "CPU part")
_VECTORS = ("avx512f", "avx2", "sve2", "sve", "asimd")


def machine() -> list[str]:
    """Sentences: the processor, the compiler of our kernel, versions."""
    return [
        f"Processor: {_model()} ({platform.machine()}, {_vectors()}), {platform.system()}. One core, CPU time.",
        f"Compiler of hillobs and of the peaks: {_compiler()}.",
        "Versions: "
        + ", ".join([f"Python {platform.python_version()}", *filter(None, map(_version, _PACKAGES))])
        + ".",
    ]


def _model() -> str:
    return next(filter(None, map(cpuinfo, _MODEL)), platform.processor() or "unknown")


def _vectors() -> str:
    known = features()
    return next((name for name in _VECTORS if name in known), "no vectors known of")


def _compiler() -> str:
    try:
        return find_compiler().version.splitlines()[0]
    except BuildError as error:
        return str(error)


def _version(package: str) -> str:
    try:
        return f"{package} {metadata.version(package)}"
    except metadata.PackageNotFoundError:
        return ""
