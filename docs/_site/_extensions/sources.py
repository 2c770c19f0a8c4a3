"""Links of pages that lead out of them: files of the source tree are copied, its folders are only named."""

from __future__ import annotations

import re
from pathlib import Path

from sphinx.application import Sphinx

_OUTSIDE = re.compile(r"\[([^\]]+)\]\((\.\./[^)#\s]*)\)")


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to the reading of pages."""
    app.connect("source-read", _rewrite)
    return {"parallel_read_safe": True}


def _rewrite(app: Sphinx, page: str, source: list[str]) -> None:
    def link(match: re.Match[str]) -> str:
        target = Path(app.env.doc2path(page)).parent.joinpath(match[2]).resolve()
        if not target.exists():
            raise FileNotFoundError(f"{page} links to {match[2]}, which is not there")
        if target.is_relative_to(app.srcdir):
            return match[0]
        return match[0] if target.is_file() and target.suffix != ".md" else f"`{match[1].strip('`')}`"

    source[0] = _OUTSIDE.sub(link, source[0])
