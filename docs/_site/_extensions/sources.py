"""Links of pages that lead out of them: files of the source tree are copied, its folders are only named.

Three pages stand at the root of the source tree, where one looks for them; the site shows them as pages of its own.
"""

from __future__ import annotations

import os.path
import re
from pathlib import Path

from sphinx.application import Sphinx

# page of the site: file at the root
BORROWED = {"contributing": "CONTRIBUTING.md", "security": "SECURITY.md", "changelog": "CHANGELOG.md"}
_LINK = re.compile(r"\[([^\]]+)\]\((?!\w+:)([^)#\s]+)(#[^)\s]*)?\)")


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to the reading of pages."""
    app.connect("source-read", _rewrite)
    return {"parallel_read_safe": True}


def _rewrite(app: Sphinx, page: str, source: list[str]) -> None:
    here = Path(app.env.doc2path(page)).parent
    root = Path(app.srcdir).parent
    pages = {root / file: Path(app.srcdir, f"{name}.md") for name, file in BORROWED.items()}
    base = here
    if page in BORROWED:
        source[0] = (root / BORROWED[page]).read_text(encoding="utf-8")
        base = root

    def link(match: re.Match[str]) -> str:
        words, there, anchor = match[1], (base / match[2]).resolve(), match[3] or ""
        if not there.exists():
            raise FileNotFoundError(f"{page} links to {match[2]}, which is not there")
        there = pages.get(there, there)
        if there.is_relative_to(app.srcdir) or (there.is_file() and there.suffix != ".md"):
            return f"[{words}]({os.path.relpath(there, here)}{anchor})"
        return f"`{words.strip('`')}`"

    source[0] = _LINK.sub(link, source[0])
