"""dask.distributed, an extra of hillobs: imported when a cluster is asked for, since that takes half a second."""

from __future__ import annotations

import importlib
from types import ModuleType

from ...files.dask import let_in
from ...files.errors import ClusterError


def distributed() -> ModuleType:
    """The package `distributed`. ClusterError if it is not installed."""
    let_in()
    try:
        return importlib.import_module("distributed")
    except ImportError as error:
        raise ClusterError("a cluster needs dask: pip install 'hillobs[cluster]'") from error
