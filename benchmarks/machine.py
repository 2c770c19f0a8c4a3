"""The machine and the programs that were measured."""

from __future__ import annotations

import contextlib
import platform
from importlib import metadata
from pathlib import Path

from hillobs.codegen.cache import BuildError
from hillobs.codegen.toolchain import find_compiler

_PACKAGES = ("casadi", "numpy", "scipy", "numba", "jax")
# of /proc/cpuinfo, on x86 and elsewhere
_MODEL = ("model name", "Model", "CPU part")
_VECTORS = ("avx512f", "avx2", "sve2", "sve", "asimd")


def machine() -> list[str]:
    """Sentences: the processor, the compiler of our kernel, versions."""
    return [
        f"Processor: {_cpu('model') or platform.processor() or 'unknown'} ({platform.machine()}, {_cpu('vectors')}), "
        f"{platform.system()}. One core, CPU time.",
        f"Compiler of hillobs and of the peaks: {_compiler()}.",
        "Versions: "
        + ", ".join([f"Python {platform.python_version()}", *filter(None, map(_version, _PACKAGES))])
        + ".",
    ]


def _cpu(what: str) -> str:
    fields: dict[str, str] = {}
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text("ascii", "replace").splitlines():
            name, _, value = line.partition(":")
            fields.setdefault(name.strip(), value.strip())
    if what == "model":
        return next((fields[name] for name in _MODEL if name in fields), "")
    known = set((fields.get("flags") or fields.get("Features") or "").split())
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
