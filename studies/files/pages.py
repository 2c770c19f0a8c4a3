"""Where the pages of documentation and the recordings are, in a checkout and in an installed copy alike."""

from __future__ import annotations

import difflib
from pathlib import Path

from .errors import ScenarioError
from .quote import shown

# letters of a name that are compared with those of pages
_LONGEST = 100


def documentation() -> Path:
    """The folder of model.md, observers.md and the others: what `docs/…` in the source of a parameter names."""
    # both have the folder `docs` beside `studies`
    return Path(__file__).parents[2] / "docs"


def recordings() -> Path:
    """The folder of the recordings, muscles and mechanisms that come with hillobs."""
    return Path(__file__).parents[1] / "laboratory" / "recordings"


def page(name: str) -> Path:
    """The page of a name, such as `observers`; ScenarioError with the nearest names if there is none."""
    folder = documentation()
    pages = {
        path.stem: path
        for place in (folder, folder / "how-to", folder / "tutorials")
        for path in sorted(place.glob("*.md"))
    }
    if name in pages:
        return pages[name]
    near = difflib.get_close_matches(name[:_LONGEST], pages, n=3) or pages
    raise ScenarioError(f"there is no page {shown(name)}; there are {', '.join(near)}")
