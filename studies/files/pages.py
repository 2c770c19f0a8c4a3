"""Where the pages of documentation are, in a checkout and in an installed copy alike."""

from __future__ import annotations

from pathlib import Path


def documentation() -> Path:
    """The folder of model.md, observers.md and the others: what `docs/…` in the source of a parameter names."""
    # both have the folder `docs` beside `studies`
    return Path(__file__).parents[2] / "docs"
