"""SciPy, which is an extra: parts of it are imported when they are needed."""

from __future__ import annotations

import importlib
from types import ModuleType

from ..files.errors import ScenarioError


def scipy(part: str) -> ModuleType:
    """A module of SciPy. ScenarioError says how to get it."""
    try:
        return importlib.import_module(f"scipy.{part}")
    except ImportError as error:
        raise ScenarioError("calibration needs SciPy: pip install 'hillobs[calibrate]'") from error
