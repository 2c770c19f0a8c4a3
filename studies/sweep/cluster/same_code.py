"""Whether two machines run the same code: without it their results differ in the last bits."""

from __future__ import annotations

import functools
import hashlib
import platform
from collections.abc import Mapping
from importlib import metadata, resources
from pathlib import Path

from ....codegen.system.processor import cpuinfo
from ....codegen.toolchain import find_compiler

_ROOMS = ("model", "observers", "codegen", "studies")
_SOURCES = (".py", ".cpp", ".hpp")
_SHORT = 12  # digits of a hash that people are shown
# two machines must agree on these; the other entries say why they do not
_NEEDED = ("hillobs", "its source", "C library", "compiled library")


@functools.cache
def code(library: Path) -> dict[str, str]:
    """What determines results here, `library` being the one that computes them.

    Its bytes count, not its name, which also holds the compiler's path and what the processor can.
    """
    return {
        "hillobs": metadata.version("hillobs"),
        "its source": _source(),
        "casadi": metadata.version("casadi"),
        "compiler": find_compiler().version.partition("\n")[0],
        "C library": " ".join(platform.libc_ver()).strip() or platform.platform(),
        "processor": cpuinfo("model name") or platform.machine(),
        "compiled library": hashlib.sha256(library.read_bytes()).hexdigest()[:_SHORT],
    }


def difference(there: Mapping[str, str], here: Mapping[str, str]) -> str:
    """What differs between two machines, or an empty text if both compute the same bits."""
    if all(there.get(name) == here[name] for name in _NEEDED):
        return ""
    different = [name for name in here if there.get(name) != here[name]]
    # the library differs because something else does, if we know what
    named = [name for name in different if name != "compiled library"] or different
    return ", ".join(f"{name} {there.get(name, 'unknown')} there and {here[name]} here" for name in named)


def _source() -> str:
    """A hash of hillobs' own files: what a version number does not tell of a checkout."""
    digest = hashlib.sha256()
    for room in _ROOMS:
        root = Path(str(resources.files(f"hillobs.{room}")))
        for path in sorted(path for path in root.rglob("*") if path.suffix in _SOURCES):
            name = f"{room}/{path.relative_to(root).as_posix()}"
            digest.update(f"{name}\n".encode() + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:_SHORT]
