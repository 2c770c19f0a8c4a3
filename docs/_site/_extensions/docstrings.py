"""Docstrings as Sphinx reads them: ours are plain text, with code in single backticks or indented, and examples.

A line that begins with the name of an argument and a colon is about that argument.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Container, Iterator

from sphinx.application import Sphinx

# what would be markup: *, | and _ at the end of a word
_MARKS = re.compile(r"[*|]|_(?!\w)")
_CODE = re.compile(r"`([^`]+)`")
# of one argument or several
_ABOUT = re.compile(r"((?:\w+, )*\w+): ")


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to autodoc."""
    app.connect("autodoc-process-docstring", _rewrite)
    return {"parallel_read_safe": True}


def _rewrite(app: Sphinx, what: str, name: str, object_: object, options: object, lines: list[str]) -> None:
    arguments = _arguments(object_)
    lines[:] = [
        line for paragraph in _paragraphs(lines) for block in _blocks(paragraph, arguments) for line in (*block, "")
    ]


def _arguments(object_: object) -> Container[str]:
    try:
        return inspect.signature(object_).parameters if callable(object_) else ()
    except ValueError:  # built in
        return ()


def _paragraphs(lines: list[str]) -> list[list[str]]:
    text = "\n".join(lines).strip("\n")
    return [paragraph.split("\n") for paragraph in re.split(r"\n\s*\n", text)] if text else []


def _blocks(paragraph: list[str], arguments: Container[str]) -> Iterator[list[str]]:
    """The parts of a paragraph: an example, code, arguments, sentences."""
    if paragraph[0].startswith(">>> "):
        yield paragraph
        return
    if all(line.startswith("    ") for line in paragraph):
        yield ["::", "", *paragraph]
        return
    fields: list[str] = []
    sentences: list[str] = []
    for sentence in re.split(r"(?<=[.;]) (?=\w+: )|\n(?=[A-Z(]|(?:\w+, )*\w+: )", "\n".join(map(str.strip, paragraph))):
        about = _ABOUT.match(sentence)
        names = about[1].split(", ") if about else []
        if names and all(name in arguments for name in names):
            fields.append(f":param {about[1]}: {_text(_one_line(sentence[about.end() :]))}")
        else:
            sentences.append(_text(_one_line(sentence)))
    yield sentences
    yield fields


def _one_line(sentence: str) -> str:
    return " ".join(sentence.split("\n"))


def _text(line: str) -> str:
    parts = _CODE.split(line)
    # every second part was between backticks
    return "".join(f"``{part}``" if i % 2 else _MARKS.sub(r"\\\g<0>", part) for i, part in enumerate(parts))
