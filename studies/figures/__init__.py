"""A Dataset as figures, whatever the user's matplotlib is set to."""

from __future__ import annotations

import contextlib
import importlib
import logging
import os
import sys
from collections.abc import Iterator

from ..files.errors import ResultError


@contextlib.contextmanager
def _without_settings() -> Iterator[None]:
    """matplotlib's variables for a backend and for settings hidden, and nothing said of a folder for its fonts."""
    hidden = {"MPLBACKEND": "", "MATPLOTLIBRC": os.devnull}
    before = {name: os.environ.get(name) for name in hidden}
    os.environ.update(hidden)
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


# read once, at the first import; our figures go into files and have their own settings, see page.py
if "matplotlib" not in sys.modules:
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    with _without_settings():
        try:
            # it lists the fonts
            importlib.import_module("matplotlib.font_manager")
        except (OSError, ValueError) as error:
            raise ResultError(f"matplotlib cannot be loaded: {error}; is ./matplotlibrc broken?") from error
