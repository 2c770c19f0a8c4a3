"""The versions that determine a result."""

from __future__ import annotations

import platform
from importlib import metadata

# read once, at the start: when a long computation is done, there may be no file descriptor left for it
_VERSIONS = {name: metadata.version(name) for name in ("hillobs", "casadi", "numpy", "xarray")}
__version__ = _VERSIONS["hillobs"]


def versions() -> dict[str, str]:
    """Name → version of everything that computes."""
    return {"python": platform.python_version(), **_VERSIONS}
