"""Where a file that a command is told to write will be."""

from __future__ import annotations

from pathlib import Path

from ...files.errors import ScenarioError
from ...files.quote import shown
from ...files.writing import refuse_overwriting, writable_folder

_SUFFIX = ".toml"


def toml_place(out: str) -> Path:
    """The place of --out FILE.toml. ScenarioError or ResultError if no such file can be there."""
    place = Path(out)
    if place.suffix != _SUFFIX:
        raise ScenarioError(f"--out must be a {_SUFFIX} file, not {shown(out)}")
    writable_folder(place.parent)
    refuse_overwriting([place])
    return place
