"""dask stays out of a command that does not ask for it: xarray takes it along, which takes as long as a run."""

from __future__ import annotations

import sys

_NAME = "dask"


def leave_out() -> None:
    """Importing it fails from now on, as where it is not installed; unless xarray is there, which has looked."""
    if "xarray" not in sys.modules:
        sys.modules.setdefault(_NAME, None)  # type: ignore[arg-type]  # Python's sign for what must not be imported


def let_in() -> None:
    """It can be imported again."""
    if _NAME in sys.modules and sys.modules[_NAME] is None:
        del sys.modules[_NAME]
