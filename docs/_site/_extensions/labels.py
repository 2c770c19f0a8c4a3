"""The labels of the paper's equations as links: each leads to where its equation stands on these pages."""

from __future__ import annotations

import os.path
import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_DOCS = Path(__file__).parents[2]
# where equations stand, in this order
PAGES = ("model", "observers", "gains", "errata")
# [load1], or several, [dotla, rhoa0]; no link of Markdown and no interval
_LABELS = re.compile(r"(?<![\w\])])\[([A-Za-z]\w*(?:, [A-Za-z]\w*)*)\](?!\()")
_RANGE = re.compile(r"\[([A-Za-z]+)(\w*)\]–\[\1(\w*)\]")
# code, fenced, indented or within a line, in which nothing is a link
_CODE = re.compile(r"^```.*?^```|^(?: {4}|\t).*?$|`[^`\n]*`", re.MULTILINE | re.DOTALL)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to the reading of pages."""
    home = homes()

    def rewrite(app: Sphinx, page: str, source: list[str]) -> None:
        source[0] = linked(source[0], page, home)

    app.connect("source-read", rewrite)
    return {"parallel_read_safe": True}


def homes() -> dict[str, tuple[str, str]]:
    """The `places` of our pages, whichever are being built."""
    pages = {name: (_DOCS / f"{name}.md").read_text(encoding="utf-8") for name in PAGES}
    known = set((_DOCS.parent / "tests" / "data" / "paper_labels.txt").read_text(encoding="utf-8").split())
    return places(pages, known)


def places(pages: dict[str, str], known: set[str]) -> dict[str, tuple[str, str]]:
    """Label → the page on which it stands first, and the label that has its place there."""
    found: dict[str, tuple[str, str]] = {}
    for name, text in pages.items():
        prose = _CODE.sub(lambda code: " " * len(code[0]), text)
        for group in _LABELS.findall(prose):
            for label in group.split(", "):
                if label in known:
                    found.setdefault(label, (name, label))
        # [HO1a]–[HO3b] is about all in between
        for letters, first, last in _RANGE.findall(prose):
            for label in known:
                inside = re.fullmatch(rf"{letters}(\d\w*)", label)
                if inside and first <= inside[1] <= last:
                    found.setdefault(label, (name, f"{letters}{first}"))
    return found


def linked(text: str, page: str, home: dict[str, tuple[str, str]]) -> str:
    """The Markdown of a page with its labels as links; the first of each that stands here is a place."""
    placed: set[str] = set()

    def link(label: str) -> str:
        if label not in home:
            return label
        where, anchor = home[label]
        place = f' id="eq-{label}"' if (where, anchor) == (page, label) and label not in placed else ""
        placed.add(label)
        target = os.path.relpath(f"{where}.html", os.path.dirname(page) or ".") if where != page else ""
        return f'<a class="equation"{place} href="{target}#eq-{anchor}">{label}</a>'

    def group(match: re.Match[str]) -> str:
        labels = match[1].split(", ")
        return f"[{', '.join(map(link, labels))}]" if any(label in home for label in labels) else match[0]

    parts, end = [], 0
    for code in _CODE.finditer(text):
        parts += [_LABELS.sub(group, text[end : code.start()]), code[0]]
        end = code.end()
    return "".join([*parts, _LABELS.sub(group, text[end:])])
