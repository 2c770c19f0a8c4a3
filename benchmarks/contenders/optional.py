"""Packages of the extra `bench`."""

from __future__ import annotations

import importlib
from typing import Any

from . import AbsentError


def imported(module: str, package: str = "") -> Any:  # noqa: ANN401  whatever the module holds
    """The module, or AbsentError."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        name = package or module
        raise AbsentError(f"{name} is not installed: pip install 'hillobs[bench]'") from error
