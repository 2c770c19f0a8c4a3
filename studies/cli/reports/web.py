"""A page for a browser in one file: it loads nothing, runs nothing, and shows the words of others as words."""

from __future__ import annotations

import base64
import hashlib
import html
from collections.abc import Iterable, Sequence
from importlib import resources
from string import Template

from ...files.quote import escaped

_ROOM = "hillobs.studies.cli.reports"
_FILES = ("page.html", "page.css")


def page(title: str, body: Iterable[str]) -> bytes:
    """The page, UTF-8; `body` is HTML, such as the other functions here make, `title` are words."""
    template, style = (resources.files(_ROOM).joinpath(name).read_text(encoding="utf-8") for name in _FILES)
    # the only style that the browser may use
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    filled = Template(template).substitute(
        title=words(title), style=style, style_hash=f"sha256-{digest}", body="\n".join(body)
    )
    return filled.encode()


def words(text: object) -> str:
    """Words of anybody as HTML that shows them, what cannot be printed as escapes."""
    return html.escape(escaped(str(text)))


def section(heading: str, *parts: str) -> str:
    """A heading and what belongs to it, which is HTML."""
    return "\n".join([f"<section>\n<h2>{words(heading)}</h2>", *parts, "</section>"])


def listed(sentences: Iterable[str]) -> str:
    """Sentences as a list; what begins with blanks stands further in, as on a terminal."""
    items = [f"<li{' class=under' * sentence.startswith(' ')}>{words(sentence.strip())}</li>" for sentence in sentences]
    return "\n".join(["<ul>", *items, "</ul>"])


def table(
    rows: Iterable[Sequence[object]], head: Sequence[object] = (), caption: str = "", words_in: bool = False
) -> str:
    """A table, the first cell of each row its heading; with `words_in` the others are no numbers."""
    top = "".join(f'<th scope="col">{words(cell)}</th>' for cell in head)
    return "\n".join(
        [
            f'<div class="wide"><table class="{"words" if words_in else "numbers"}">',
            *([f"<caption>{words(caption)}</caption>"] if caption else []),
            *([f"<thead><tr>{top}</tr></thead>"] if head else []),
            "<tbody>",
            *(_row(row) for row in rows),
            "</tbody></table></div>",
        ]
    )


def image(png: bytes, caption: str) -> str:
    """A figure, in the page itself."""
    source = base64.b64encode(png).decode()
    return (
        f'<figure><div class="wide"><img alt="{words(caption)}" src="data:image/png;base64,{source}"></div>'
        f"<figcaption>{words(caption)}</figcaption></figure>"
    )


def _row(row: Sequence[object]) -> str:
    first, *others = map(words, row)
    return f'<tr><th scope="row">{first}</th>{"".join(f"<td>{cell}</td>" for cell in others)}</tr>'
