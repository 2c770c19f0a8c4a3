"""dask stays out of a command that does not ask for it: xarray takes it along, which takes as long as a run."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import cast

_NAME = "dask"
# None is Python's sign for what must not be imported
_MODULES = cast(dict[str, ModuleType | None], sys.modules)


def leave_out() -> None:
    """Importing it fails from now on, as where it is not installed; unless xarray is there, which has looked."""
    if "xarray" not in _MODULES:
        _MODULES.setdefault(_NAME, None)


def let_in() -> None:
    """It can be imported again."""
    if _NAME in _MODULES and _MODULES[_NAME] is None:
        del _MODULES[_NAME]
