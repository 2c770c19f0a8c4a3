"""The kinds of machine that an FMU can have a library for, and which of them can be compiled for here."""

from __future__ import annotations

import platform as machine
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..cache import BuildError
from ..toolchain import zig


@dataclass(frozen=True)
class Platform:
    """A kind of machine: its name, the folder of its library by version of FMI, the library's suffix.

    target: what zig calls it; nothing if it is this machine, whose own compiler serves.
    """

    name: str
    folders: Mapping[str, str]
    suffix: str
    target: str


def _platform(name: str, second: str, suffix: str, target: str) -> Platform:
    return Platform(name, {"2.0": second, "3.0": name}, suffix, target)


# by the names of FMI 3.0; FMI 2.0 has a folder for each system, where macOS has one library for both processors
_KNOWN = (
    _platform("x86_64-linux", "linux64", ".so", "x86_64-linux-gnu.2.17"),
    _platform("aarch64-linux", "aarch64-linux", ".so", "aarch64-linux-gnu.2.17"),
    _platform("x86_64-windows", "win64", ".dll", "x86_64-windows-gnu"),
    _platform("x86_64-darwin", "darwin64", ".dylib", "x86_64-macos.11.0"),
    _platform("aarch64-darwin", "darwin64", ".dylib", "aarch64-macos.11.0"),
)
_SPELLED = {"amd64": "x86_64", "arm64": "aarch64"}


def platforms() -> list[Platform]:
    """Those that can be compiled for: this machine, and with the `ziglang` wheel all. BuildError if there are none."""
    kind = machine.machine().lower()
    here = f"{_SPELLED.get(kind, kind)}-{sys.platform}"
    found = [replace(known, target="") if known.name == here else known for known in _KNOWN]
    if zig() is None:
        found = [known for known in found if not known.target]
    if not found:
        raise BuildError(
            f"FMI has no name for this machine, {here}; `pip install 'hillobs[compiler]'` serves the others."
        )
    return found
