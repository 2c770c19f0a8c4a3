"""XML of others as plain elements: no document type, no entities, no files or network, and bounded.

Expat of the standard library expands no more than the five characters that XML names itself once a document type is
refused, since entities are declared nowhere else; size, depth and number of elements bound the rest.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from ...files.errors import ScenarioError
from ...files.quote import short, shown
from ...files.reading import cause, read_whole

# whole bodies with hundreds of muscles have some megabytes, a hundred thousand elements and a depth of about fifteen
_LARGEST_FILE, _MOST_ELEMENTS, _DEEPEST, _LONGEST_NAME = 30_000_000, 500_000, 100, 200


@dataclass
class Element:
    """An element: its tag, its name or an empty string, its line, its words, and what it holds."""

    tag: str
    name: str = ""
    line: int = 0
    words: str = ""
    children: list[Element] = field(default_factory=list)

    def child(self, tag: str) -> Element | None:
        """The first one with this tag."""
        return next((child for child in self.children if child.tag == tag), None)

    def within(self, *tags: str) -> Element | None:
        """The first one by a chain of tags."""
        found: Element | None = self
        for tag in tags:
            found = found and found.child(tag)
        return found

    def walk(self) -> Iterator[Element]:
        """It and all that it holds, each before what it holds itself."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting.extend(reversed(element.children))


def read_xml(path: Path) -> Element:
    """The root of a file. ScenarioError says what is wrong, and where in the file."""
    try:
        raw = read_whole(path, _LARGEST_FILE)
    except (OSError, ValueError) as error:
        raise ScenarioError(f"cannot be read: {cause(error)}") from error
    return _parsed(raw)


def _parsed(raw: bytes) -> Element:
    parser = expat.ParserCreate()
    parser.buffer_text = True
    top = Element("")
    open_elements = [top]
    pieces: dict[int, list[str]] = {}
    count = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > _MOST_ELEMENTS or len(open_elements) > _DEEPEST:
            many = f"more than {_MOST_ELEMENTS:,} elements" if count > _MOST_ELEMENTS else f"deeper than {_DEEPEST}"
            raise ScenarioError(f"line {parser.CurrentLineNumber}: {many}; no OpenSim model is so large")
        if len(attributes.get("name", "")) > _LONGEST_NAME:
            raise ScenarioError(f"line {parser.CurrentLineNumber}: a name of more than {_LONGEST_NAME} characters")
        element = Element(tag, attributes.get("name", ""), parser.CurrentLineNumber)
        open_elements[-1].children.append(element)
        open_elements.append(element)

    def end(tag: str) -> None:
        del tag
        element = open_elements.pop()
        # joined once: with remarks between there may be a million pieces
        element.words = "".join(pieces.pop(id(element), ()))

    def words(text: str) -> None:
        pieces.setdefault(id(open_elements[-1]), []).append(text)

    def refuse(*declared: object) -> None:
        raise ScenarioError(
            f"line {parser.CurrentLineNumber}: declares a document type, {shown(declared[0])}; OpenSim writes none, "
            "and the entities that it can bring in are not read"
        )

    parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = start, end, words
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(raw, True)
    except ScenarioError:
        raise
    except expat.ExpatError as error:
        what = expat.errors.messages[error.code]
        raise ScenarioError(f"not valid XML: line {error.lineno}: {short(what)}") from error
    except (LookupError, ValueError) as error:  # an encoding that Python does not know, or of several bytes a letter
        raise ScenarioError("not valid XML: it is in an encoding that cannot be read; save it as UTF-8") from error
    return top.children[0]
