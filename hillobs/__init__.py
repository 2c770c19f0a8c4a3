"""Observers for a pair of Hill muscles: states, unknown inputs and activations from a position and two forces."""

from __future__ import annotations

import importlib
from importlib.metadata import version
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .studies.conformance import conformance
    from .studies.estimate.run import estimate
    from .studies.observability.point import observability
    from .studies.simulate.run import simulate
    from .studies.sweep.run import sweep

__version__ = version("hillobs")

_PLACES = {
    "conformance": ".studies.conformance",
    "estimate": ".studies.estimate.run",
    "observability": ".studies.observability.point",
    "simulate": ".studies.simulate.run",
    "sweep": ".studies.sweep.run",
}


def __getattr__(name: str) -> object:
    """Heavy modules are imported when they are first used."""
    if name not in _PLACES:
        raise AttributeError(f"module 'hillobs' has no attribute {name!r}; there are {', '.join(__all__)}")
    return getattr(importlib.import_module(_PLACES[name], __name__), name)


__all__ = ["__version__", "conformance", "estimate", "observability", "simulate", "sweep"]
