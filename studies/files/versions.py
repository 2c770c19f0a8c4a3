"""The versions that determine a result."""

from __future__ import annotations

import platform
from importlib import metadata

__version__ = metadata.version("hillobs")


def versions() -> dict[str, str]:
    """Name → version of everything that computes."""
    packages = ("hillobs", "casadi", "numpy", "xarray")
    return {"python": platform.python_version(), **{name: metadata.version(name) for name in packages}}
